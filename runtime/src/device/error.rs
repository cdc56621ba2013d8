//! What can go wrong on a device.

/// A failure on a device, with the object and the cause.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No loader, no platform or no device.
    #[error(
        "no OpenCL device found ({cause})\n  help: install a driver; for the CPU: `apt-get install pocl-opencl-icd`, \
         or run `make device`"
    )]
    NoDevice {
        /// What the system said.
        cause: String,
    },
    /// No device has this number or name.
    #[error("no OpenCL device matches `{wanted}`\n  help: the devices here: {known}")]
    UnknownDevice {
        /// What was asked for.
        wanted: String,
        /// Numbers and names of the devices.
        known: String,
    },
    /// The device has no 64-bit floats.
    #[error("`{device}` has no 64-bit floats, which the reference precision needs")]
    NoDouble {
        /// The device's name.
        device: String,
    },
    /// A buffer could not be had.
    #[error(
        "`{device}` is out of memory: buffer `{buffer}` needs {bytes} bytes ({available} in all on the device)\n  help: use fewer triangles or a smaller picture"
    )]
    OutOfMemory {
        /// The device's name.
        device: String,
        /// The buffer's label.
        buffer: String,
        /// Bytes asked for.
        bytes: u64,
        /// Bytes of global memory.
        available: u64,
    },
    /// A program did not build.
    #[error("OpenCL program `{program}` does not build on `{device}`: {code}\n{log}")]
    Build {
        /// The program's label.
        program: String,
        /// The device's name.
        device: String,
        /// The driver's error.
        code: String,
        /// The build log, shortened.
        log: String,
    },
    /// A kernel got other arguments than it has.
    #[error("kernel `{kernel}` takes {expected} arguments, {given} are given")]
    Arguments {
        /// The kernel.
        kernel: String,
        /// As declared.
        expected: u32,
        /// As given.
        given: u32,
    },
    /// A transfer goes beyond its buffer.
    #[error("{bytes} bytes do not fit buffer `{buffer}` of {size}")]
    Size {
        /// The buffer's label.
        buffer: String,
        /// Bytes of the transfer.
        bytes: u64,
        /// Bytes of the buffer.
        size: u64,
    },
    /// Anything else that the driver refuses.
    #[error("`{device}`: {what} failed: {code}")]
    Driver {
        /// The device's name.
        device: String,
        /// What was being done.
        what: String,
        /// The driver's error.
        code: String,
    },
}
