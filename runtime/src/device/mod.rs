//! OpenCL devices: bytes, programs and kernels.
//!
//! In: sizes, bytes, source text. Out: bytes and build logs. The only place with opencl3 and `unsafe`. It must not know
//! scenes, shaders or stages.

mod error;
mod kernel;
mod linked;
mod memory;

pub use error::Error;
pub use kernel::{Arg, Kernel, Program};
pub use memory::{Buffer, Plain};

use crate::builders::Recipe;
use crate::cache::Cache;
use opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::device::{CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU};
use opencl3::error_codes::ClError;
use opencl3::platform::get_platforms;
use std::sync::{Arc, Mutex, PoisonError};

/// What a device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// Runs on the host's cores.
    Cpu,
    /// A graphics processor.
    Gpu,
    /// Anything else.
    Other,
}

/// What is known of a device without opening it.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Its name.
    pub name: String,
    /// Its platform's name.
    pub platform: String,
    /// OpenCL version.
    pub version: String,
    /// Driver version.
    pub driver: String,
    /// CPU or GPU.
    pub kind: DeviceKind,
    /// Bytes of global memory.
    pub memory: u64,
    /// Bytes of the largest buffer.
    pub largest_buffer: u64,
    /// Compute units.
    pub units: u32,
    /// Has 64-bit floats.
    pub double: bool,
    id: opencl3::types::cl_device_id,
}

// SAFETY: a cl_device_id is a handle that OpenCL allows any thread to use (OpenCL 3.0, section 3.1 and appendix A.2).
unsafe impl Send for DeviceInfo {}
// SAFETY: as above; the handle is never changed.
unsafe impl Sync for DeviceInfo {}

fn words(e: ClError) -> String {
    format!("{e}")
}

/// All devices, in the order that numbers name them: platforms as the loader gives them.
pub fn list() -> Result<Vec<DeviceInfo>, Error> {
    // PoCL 3.1 answers "no device" to a thread that asks while another is setting it up.
    static ASKING: Mutex<()> = Mutex::new(());
    let _asking = ASKING.lock().unwrap_or_else(PoisonError::into_inner);
    let platforms = get_platforms().map_err(|e| Error::NoDevice { cause: words(e) })?;
    let mut out = Vec::new();
    for platform in platforms {
        // A platform without devices answers with an error; the others still count.
        let Ok(ids) = platform.get_devices(CL_DEVICE_TYPE_ALL) else { continue };
        for id in ids {
            let device = opencl3::device::Device::new(id);
            let kind = match device.dev_type() {
                Ok(t) if t & CL_DEVICE_TYPE_GPU != 0 => DeviceKind::Gpu,
                Ok(t) if t & CL_DEVICE_TYPE_CPU != 0 => DeviceKind::Cpu,
                _ => DeviceKind::Other,
            };
            let text = |r: Result<String, ClError>| r.unwrap_or_default().trim().to_string();
            out.push(DeviceInfo {
                name: text(device.name()),
                platform: text(platform.name()),
                version: text(device.version()),
                driver: text(device.driver_version()),
                kind,
                memory: device.global_mem_size().unwrap_or(0),
                largest_buffer: device.max_mem_alloc_size().unwrap_or(u64::MAX),
                units: device.max_compute_units().unwrap_or(1),
                double: device.double_fp_config().is_ok_and(|c| c != 0),
                id,
            });
        }
    }
    if out.is_empty() { Err(Error::NoDevice { cause: "no platform has a device".into() }) } else { Ok(out) }
}

/// An open device with one in-order queue.
pub struct Device {
    /// What it is.
    pub info: DeviceInfo,
    pub(in crate::device) context: Context,
    pub(in crate::device) queue: CommandQueue,
    /// Where binaries of its programs are kept, if anywhere.
    cache: Option<Arc<Cache>>,
    /// How processes are started that build programs for it, if there may be any.
    builders: Option<Recipe>,
}

impl Device {
    /// Opens the device with this number or part of a name (upper and lower case alike); without one, the first GPU, else
    /// the first device.
    pub fn open(wanted: Option<&str>) -> Result<Device, Error> {
        let mut all = list()?;
        let index = match wanted {
            None => all.iter().position(|d| d.kind == DeviceKind::Gpu).unwrap_or(0),
            Some(text) => {
                let lower = text.to_lowercase();
                let number = text.parse::<usize>().ok().filter(|i| *i < all.len());
                let named = || {
                    // Every name has the empty text in it.
                    if lower.is_empty() {
                        return None;
                    }
                    all.iter().position(|d| {
                        d.name.to_lowercase().contains(&lower) || d.platform.to_lowercase().contains(&lower)
                    })
                };
                number.or_else(named).ok_or_else(|| Error::UnknownDevice {
                    wanted: text.to_string(),
                    known: all
                        .iter()
                        .enumerate()
                        .map(|(i, d)| format!("{i}: {}", d.name))
                        .collect::<Vec<_>>()
                        .join("; "),
                })?
            }
        };
        let info = all.swap_remove(index);
        let device = opencl3::device::Device::new(info.id);
        let fail =
            |what: &str, e: ClError| Error::Driver { device: info.name.clone(), what: what.into(), code: words(e) };
        let context = Context::from_device(&device).map_err(|e| fail("opening a context", e))?;
        // SAFETY: the context is valid and holds exactly this device; the properties are a plain bit mask.
        let queue = unsafe { CommandQueue::create(&context, info.id, CL_QUEUE_PROFILING_ENABLE) }
            .map_err(|e| fail("creating a queue", e))?;
        Ok(Device { info, context, queue, cache: None, builders: None })
    }

    /// The same device, whose programs are kept for the next process.
    pub fn with_cache(self, cache: Option<Arc<Cache>>) -> Device {
        Device { cache, ..self }
    }

    /// Where binaries of its programs are kept, if anywhere.
    pub fn cache(&self) -> Option<&Cache> {
        self.cache.as_deref()
    }

    /// The same device, whose programs may be built by processes of their own, into its cache.
    pub fn with_builders(self, builders: Option<Recipe>) -> Device {
        Device { builders, ..self }
    }

    /// How processes are started that build programs for it: only where more than one process helps, and with a cache.
    pub fn builders(&self) -> Option<&Recipe> {
        // NVIDIA's driver (seen with 580.159) compiles under one lock of the process: 16 threads take three quarters of the time of one.
        let one_at_a_time = self.info.platform.contains("NVIDIA");
        self.builders.as_ref().filter(|b| (one_at_a_time || b.always) && self.cache.is_some())
    }

    /// All that makes its binaries unlike those of other devices, drivers and hosts.
    pub fn identity(&self) -> Vec<String> {
        let info = &self.info;
        let device = opencl3::device::Device::new(info.id);
        let vendor = device.vendor().unwrap_or_default();
        let extensions = device.extensions().unwrap_or_default();
        let mut out =
            vec![info.name.clone(), vendor, info.version.clone(), info.driver.clone(), self.platform_version()];
        out.push(extensions);
        if info.kind == DeviceKind::Cpu {
            // Machines whose processors have one name may still have other instructions, in virtual machines above all.
            out.push(memory::host_instructions().unwrap_or_default());
        }
        out
    }

    /// Build options with what kernels know of the device (OSLCL_CPU) and those that get around what its compiler does wrong
    /// (kernels/real.h), and without its warnings: nobody reads them, and PoCL's clang counts them on standard error.
    pub fn options(&self, options: &str) -> String {
        let is_cpu = self.info.kind == DeviceKind::Cpu;
        let lane_by_lane = is_cpu && self.info.platform.contains("Intel");
        let cpu = if is_cpu { " -D OSLCL_CPU" } else { "" };
        format!("{options} -w{cpu}{}", if lane_by_lane { " -D OSLCL_LANE_BY_LANE" } else { "" })
    }

    /// Waits until all that was queued is done.
    pub fn finish(&self) -> Result<(), Error> {
        self.queue.finish().map_err(|e| self.error("waiting", e))
    }

    /// The error for work that came back wrong without a word from the driver.
    pub fn lost(&self, what: &str) -> Error {
        Error::Driver { device: self.info.name.clone(), what: "the work on the device".into(), code: what.into() }
    }

    pub(in crate::device) fn error(&self, what: &str, e: ClError) -> Error {
        Error::Driver { device: self.info.name.clone(), what: what.into(), code: words(e) }
    }
}
