//! Programs that come in other forms than source text: intermediate language linked with OpenCL C, and binaries.
//!
//! In: source text and SPIR-V words, or bytes. Out: a [`Program`]; of any program its bytes. It must not know what the code does.

use super::kernel::{Program, shorten};
use super::{Device, Error, words};
use opencl3::error_codes::ClError;
use opencl3::program::{CL_PROGRAM_BINARIES, Program as ClProgram, get_program_info, link_program, release_program};
use opencl3::types::cl_program;
use std::ptr;

/// A program that the driver holds.
pub(super) enum Handle {
    /// Made by opencl3.
    Own(ClProgram),
    /// Made by linking others.
    Linked(Linked),
}

/// What clLinkProgram gave; released when dropped.
pub(super) struct Linked(cl_program);

// SAFETY: a cl_program is a handle that OpenCL allows any thread to use (OpenCL 3.0, appendix A.2).
unsafe impl Send for Linked {}
// SAFETY: as above; the handle is never changed.
unsafe impl Sync for Linked {}

impl Drop for Linked {
    fn drop(&mut self) {
        // SAFETY: the handle came from clLinkProgram, is valid, and nobody uses it after this. A failure leaks it, no more.
        let _ = unsafe { release_program(self.0) };
    }
}

impl Handle {
    pub(super) fn get(&self) -> cl_program {
        match self {
            Handle::Own(program) => program.get(),
            Handle::Linked(program) => program.0,
        }
    }
}

impl Device {
    /// Whether the device takes SPIR-V itself.
    pub fn takes_spirv(&self) -> bool {
        let device = opencl3::device::Device::new(self.info.id);
        device.il_version().is_ok_and(|versions| versions.contains("SPIR-V"))
    }

    /// Whether the device takes the LLVM bitcode of SPIR 1.2 (`cl_khr_spir`) as a binary.
    pub fn takes_spir(&self) -> bool {
        let device = opencl3::device::Device::new(self.info.id);
        device.extensions().is_ok_and(|all| all.split_whitespace().any(|e| e == "cl_khr_spir"))
    }

    /// The version of the device's platform, with what it is built on.
    pub fn platform_version(&self) -> String {
        let device = opencl3::device::Device::new(self.info.id);
        let platform = device.platform().map(opencl3::platform::Platform::new);
        platform.and_then(|p| p.version()).unwrap_or_default()
    }

    /// Whether it adds a product of 32-bit floats without rounding it first, by its own word.
    pub fn has_fma(&self) -> bool {
        let device = opencl3::device::Device::new(self.info.id);
        device.single_fp_config().is_ok_and(|c| c & opencl3::device::CL_FP_FMA != 0)
    }
}

impl Program {
    /// Builds a program from OpenCL C and SPIR-V modules that call each other. `label` names it in errors.
    pub fn link(
        device: &Device,
        label: &str,
        source: &str,
        options: &str,
        modules: &[&[u32]],
    ) -> Result<Program, Error> {
        let fail = |code: ClError, log: String| Error::Build {
            program: label.to_string(),
            device: device.info.name.clone(),
            code: words(code),
            log: shorten(&log),
        };
        let devices = device.context.devices();
        let compiled = |made: Result<ClProgram, ClError>, options: &str| {
            let mut program = made.map_err(|e| fail(e, String::new()))?;
            match program.compile(devices, options, &[], &[]) {
                Ok(()) => Ok(program),
                Err(e) => Err(fail(e, program.get_build_log(device.info.id).unwrap_or_default())),
            }
        };
        let mut parts = vec![compiled(ClProgram::create_from_source(&device.context, source), options)?];
        for module in modules {
            let bytes: Vec<u8> = module.iter().flat_map(|w| w.to_ne_bytes()).collect();
            parts.push(compiled(ClProgram::create_from_il(&device.context, &bytes), "")?);
        }
        let handles: Vec<cl_program> = parts.iter().map(ClProgram::get).collect();
        // SAFETY: context, device and the compiled programs are valid and belong together; no callback is given, so the
        // call returns when all is done.
        let linked = unsafe { link_program(device.context.get(), devices, c"", &handles, None, ptr::null_mut()) };
        match linked {
            Ok(program) => Ok(Program { label: label.to_string(), inner: Handle::Linked(Linked(program)) }),
            Err(e) => Err(fail(ClError(e), String::new())),
        }
    }

    /// Builds a program from a binary of this device, or from bitcode where [`Device::takes_spir`]; `options` say which.
    ///
    /// Drivers may crash on bytes that are not what they wrote: the caller has to be sure of them.
    pub fn load(device: &Device, label: &str, binary: &[u8], options: &str) -> Result<Program, Error> {
        let fail = |code: ClError, log: String| Error::Build {
            program: label.to_string(),
            device: device.info.name.clone(),
            code: words(code),
            log: shorten(&log),
        };
        // SAFETY: the context holds exactly this device, and the bytes live through the call, which copies them.
        let made = unsafe { ClProgram::create_from_binary(&device.context, device.context.devices(), &[binary]) };
        let mut inner = made.map_err(|e| fail(e, String::new()))?;
        if let Err(e) = inner.build(device.context.devices(), options) {
            let log = inner.get_build_log(device.info.id).unwrap_or_default();
            return Err(fail(e, log));
        }
        Ok(Program { label: label.to_string(), inner: Handle::Own(inner) })
    }

    /// The program as the driver's binary, which only this device and driver take back.
    pub fn binary(&self, device: &Device) -> Result<Vec<u8>, Error> {
        let what = || format!("reading the binary of program `{}`", self.label);
        let all = get_program_info(self.inner.get(), CL_PROGRAM_BINARIES);
        let all: Vec<Vec<u8>> = all.map_err(|e| device.error(&what(), ClError(e)))?.into();
        all.into_iter().next().ok_or_else(|| device.lost("no binary came back"))
    }
}
