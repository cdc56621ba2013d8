//! Programs and kernels.

use super::linked::Handle;
use super::{Buffer, Device, Error, words};
use opencl3::error_codes::ClError;
use opencl3::kernel::{Kernel as ClKernel, create_kernel};
use opencl3::program::Program as ClProgram;
use opencl3::types::cl_mem;
use std::ffi::{CString, c_void};
use std::ptr;
use std::sync::Mutex;

/// Longest build log that an error shows, in bytes.
const MAX_LOG: usize = 8_000;

/// A built program.
pub struct Program {
    pub(super) label: String,
    pub(super) inner: Handle,
}

/// A kernel of a program. Arguments are set and the launch is queued under one lock.
pub struct Kernel {
    name: String,
    args: u32,
    inner: Mutex<ClKernel>,
}

/// One argument of a launch.
#[derive(Clone, Copy)]
pub enum Arg<'a> {
    /// A global pointer.
    Buffer(&'a Buffer),
    /// A null global pointer.
    Null,
    /// int
    I32(i32),
    /// uint
    U32(u32),
    /// ulong
    U64(u64),
    /// float
    F32(f32),
    /// double
    F64(f64),
    /// Local memory of this many bytes.
    Local(usize),
}

impl Program {
    /// Builds a program from source text. `label` names it in errors.
    pub fn build(device: &Device, label: &str, source: &str, options: &str) -> Result<Program, Error> {
        let fail = |code: ClError, log: String| Error::Build {
            program: label.to_string(),
            device: device.info.name.clone(),
            code: words(code),
            log: shorten(&log),
        };
        let mut inner = ClProgram::create_from_source(&device.context, source).map_err(|e| fail(e, String::new()))?;
        if let Err(e) = inner.build(device.context.devices(), options) {
            let log = inner.get_build_log(device.info.id).unwrap_or_default();
            return Err(fail(e, log));
        }
        Ok(Program { label: label.to_string(), inner: Handle::Own(inner) })
    }

    /// The kernel with this name.
    pub fn kernel(&self, device: &Device, name: &str) -> Result<Kernel, Error> {
        // A name with a zero byte in it is no kernel's.
        let text = CString::new(name).unwrap_or_default();
        let kernel = create_kernel(self.inner.get(), &text)
            .map_err(|e| device.error(&format!("finding kernel `{name}` in program `{}`", self.label), ClError(e)))?;
        let kernel = ClKernel::new(kernel);
        let args = kernel.num_args().map_err(|e| device.error("asking a kernel for its arguments", e))?;
        Ok(Kernel { name: name.to_string(), args, inner: Mutex::new(kernel) })
    }
}

/// The first lines of a log: the first error tells most.
pub(super) fn shorten(log: &str) -> String {
    let mut end = log.len().min(MAX_LOG);
    while !log.is_char_boundary(end) {
        end -= 1;
    }
    let mut out = log[..end].trim_end().to_string();
    if end < log.len() {
        out.push_str("\n...");
    }
    out
}

impl Kernel {
    /// Queues a launch over `global` work-items in groups of `local`, which must divide it.
    pub fn launch(&self, device: &Device, args: &[Arg], global: usize, local: usize) -> Result<(), Error> {
        if args.len() != self.args as usize {
            return Err(Error::Arguments { kernel: self.name.clone(), expected: self.args, given: args.len() as u32 });
        }
        // A poisoned lock only means that another launch failed; the handle is still whole.
        let kernel = self.inner.lock().unwrap_or_else(|e| e.into_inner());
        for (index, arg) in args.iter().enumerate() {
            set(&kernel, index as u32, arg)
                .map_err(|e| device.error(&format!("setting argument {index} of kernel `{}`", self.name), e))?;
        }
        // SAFETY: all arguments were just set under the lock; sizes point to arrays of the one dimension given.
        let result =
            unsafe { device.queue.enqueue_nd_range_kernel(kernel.get(), 1, ptr::null(), &global, &local, &[]) };
        result.map_err(|e| device.error(&format!("launching kernel `{}`", self.name), e))?;
        Ok(())
    }
}

fn set(kernel: &ClKernel, index: u32, arg: &Arg) -> Result<(), ClError> {
    // SAFETY: in each case size and pointer describe one live value of the type that the kernel declares; OpenCL copies
    // it before returning. A wrong type is refused by the driver by its size.
    unsafe {
        match arg {
            Arg::Buffer(buffer) => {
                let handle: cl_mem = buffer.handle();
                kernel.set_arg(index, &handle)
            }
            Arg::Null => {
                let handle: cl_mem = ptr::null_mut::<c_void>();
                kernel.set_arg(index, &handle)
            }
            Arg::I32(v) => kernel.set_arg(index, v),
            Arg::U32(v) => kernel.set_arg(index, v),
            Arg::U64(v) => kernel.set_arg(index, v),
            Arg::F32(v) => kernel.set_arg(index, v),
            Arg::F64(v) => kernel.set_arg(index, v),
            Arg::Local(bytes) => kernel.set_arg_local_buffer(index, *bytes),
        }
    }
}
