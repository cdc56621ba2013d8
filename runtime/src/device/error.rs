//! What can go wrong on a device.
//!
//! In: made by the rest of this folder. Out: printed as they are. It must not know what buffers are for.

use std::fmt;

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
    #[error("`{device}` has no 64-bit floats, which {needs} needs")]
    NoDouble {
        /// The device's name.
        device: String,
        /// The setting that needs them, `NAME=VALUE`.
        needs: &'static str,
    },
    /// A buffer could not be had.
    #[error(
        "`{device}` is out of memory: buffer `{buffer}` needs {}, the whole render {}, and there are {}\n  \
         help: use fewer triangles or a smaller picture",
        Bytes(*bytes), Bytes(*total), Bytes(*available)
    )]
    OutOfMemory {
        /// The device's name.
        device: String,
        /// The label of the largest buffer.
        buffer: String,
        /// Bytes that it asks for.
        bytes: u64,
        /// Bytes of all that is needed at once; where the device is the host, its copies too.
        total: u64,
        /// Bytes that the device has for them.
        available: u64,
    },
    /// One buffer is larger than the device takes, whatever memory there is.
    #[error("`{device}` takes no buffer of {}: `{buffer}` would have {}", Bytes(*limit), Bytes(*bytes))]
    BufferTooLarge {
        /// The device's name.
        device: String,
        /// The buffer's label.
        buffer: String,
        /// Bytes that it asks for.
        bytes: u64,
        /// Bytes of the largest that the device takes.
        limit: u64,
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

/// A number of bytes as people read it.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MIB: f64 = (1 << 20) as f64;
        let mib = self.0 as f64 / MIB;
        if self.0 < 10_000 {
            write!(out, "{} bytes", self.0)
        } else if mib < 1024.0 {
            write!(out, "{mib:.2} MiB")
        } else {
            write!(out, "{:.2} GiB", mib / 1024.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Bytes;

    #[test]
    fn bytes_have_units() {
        let said = [12, 3 << 20, 24 << 30].map(|n| Bytes(n).to_string());
        assert_eq!(said, ["12 bytes", "3.00 MiB", "24.00 GiB"]);
    }
}
