//! Buffers: labelled, sized, filled with bytes.

use super::{Device, DeviceKind, Error};
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, ClMem};
use opencl3::types::{CL_BLOCKING, cl_mem};
use std::ops::Range;
use std::ptr;

/// Types whose values are any bytes: what buffers hold.
///
/// # Safety
/// Every bit pattern must be a value, and there must be no padding.
pub unsafe trait Plain: Copy + Default + 'static {}
// SAFETY: integers and floats have no padding and no invalid patterns.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl Plain for i32 {}
// SAFETY: as above.
unsafe impl Plain for u64 {}
// SAFETY: as above.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for f64 {}

/// Device memory.
pub struct Buffer {
    label: String,
    bytes: u64,
    inner: ClBuffer<u8>,
}

impl Buffer {
    /// Size in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn handle(&self) -> cl_mem {
        self.inner.get()
    }
}

impl Device {
    /// A buffer with undefined contents. An empty one is given one byte, which OpenCL needs.
    pub fn buffer(&self, label: &str, bytes: u64) -> Result<Buffer, Error> {
        let full = || Error::OutOfMemory {
            device: self.info.name.clone(),
            buffer: label.to_string(),
            bytes,
            total: bytes,
            available: self.info.memory,
        };
        if bytes > self.info.memory {
            return Err(full());
        }
        self.check_buffer(label, bytes)?;
        let size = bytes.max(1);
        // SAFETY: no host pointer is passed, so OpenCL allocates the memory itself.
        let inner = unsafe { ClBuffer::<u8>::create(&self.context, CL_MEM_READ_WRITE, size as usize, ptr::null_mut()) };
        let inner = inner.map_err(|_| full())?;
        Ok(Buffer { label: label.to_string(), bytes: size, inner })
    }

    /// Whether one buffer can be as large as this.
    fn check_buffer(&self, label: &str, bytes: u64) -> Result<(), Error> {
        if bytes <= self.info.largest_buffer {
            return Ok(());
        }
        let (device, buffer) = (self.info.name.clone(), label.to_string());
        Err(Error::BufferTooLarge { device, buffer, bytes, limit: self.info.largest_buffer })
    }

    /// Whether buffers of these labels and sizes fit together. Call it before making them: some drivers promise more memory
    /// than there is, and have the system end the program when it is used. `beside`: bytes that the host will need at the
    /// same time; they count where host and device share their memory.
    pub fn check_room(&self, buffers: &[(&str, u64)], beside: u64) -> Result<(), Error> {
        for (label, bytes) in buffers {
            self.check_buffer(label, *bytes)?;
        }
        let of_host = self.info.kind == DeviceKind::Cpu;
        let available = if of_host {
            host_memory().map_or(self.info.memory, |free| free.min(self.info.memory))
        } else {
            self.info.memory
        };
        let total: u64 = buffers.iter().map(|(_, bytes)| bytes).sum();
        let needed = total.saturating_add(if of_host { beside } else { 0 });
        match buffers.iter().max_by_key(|(_, bytes)| *bytes) {
            Some((buffer, bytes)) if needed > available => Err(Error::OutOfMemory {
                device: self.info.name.clone(),
                buffer: (*buffer).to_string(),
                bytes: *bytes,
                total: needed,
                available,
            }),
            _ => Ok(()),
        }
    }

    /// A buffer that holds `data`.
    pub fn upload<T: Plain>(&self, label: &str, data: &[T]) -> Result<Buffer, Error> {
        let mut buffer = self.buffer(label, size_of_val(data) as u64)?;
        self.write(&mut buffer, data)?;
        Ok(buffer)
    }

    /// Writes `data` to the start of the buffer; done when it returns.
    pub fn write<T: Plain>(&self, buffer: &mut Buffer, data: &[T]) -> Result<(), Error> {
        let bytes = size_of_val(data);
        self.check_size(buffer, bytes as u64)?;
        if bytes == 0 {
            return Ok(());
        }
        // SAFETY: `T: Plain` has no padding, so its bytes may be read; the slice spans exactly the data.
        let view = unsafe { std::slice::from_raw_parts(data.as_ptr().cast::<u8>(), bytes) };
        // SAFETY: the range was checked against the buffer, and the call blocks until `view` was read.
        unsafe { self.queue.enqueue_write_buffer(&mut buffer.inner, CL_BLOCKING, 0, view, &[]) }
            .map_err(|e| self.error(&format!("writing buffer `{}`", buffer.label), e))?;
        Ok(())
    }

    /// Reads the first `count` elements; waits for all that was queued before.
    pub fn read<T: Plain>(&self, buffer: &Buffer, count: usize) -> Result<Vec<T>, Error> {
        let mut out = vec![T::default(); count];
        let bytes = size_of_val(out.as_slice());
        self.check_size(buffer, bytes as u64)?;
        if bytes == 0 {
            return Ok(out);
        }
        // SAFETY: any bytes are a `T: Plain`; the slice spans exactly `out`, which outlives the blocking call.
        let view = unsafe { std::slice::from_raw_parts_mut(out.as_mut_ptr().cast::<u8>(), bytes) };
        // SAFETY: the range was checked against the buffer, and the call blocks until `view` was written.
        unsafe { self.queue.enqueue_read_buffer(&buffer.inner, CL_BLOCKING, 0, view, &[]) }
            .map_err(|e| self.error(&format!("reading buffer `{}`", buffer.label), e))?;
        Ok(out)
    }

    /// Sets all bytes to zero, in queue order.
    pub fn clear(&self, buffer: &mut Buffer) -> Result<(), Error> {
        let bytes = buffer.bytes;
        self.clear_part(buffer, 0..bytes)
    }

    /// Sets some bytes to zero, in queue order.
    pub fn clear_part(&self, buffer: &mut Buffer, bytes: Range<u64>) -> Result<(), Error> {
        self.check_size(buffer, bytes.end)?;
        let (start, length) = (bytes.start as usize, (bytes.end - bytes.start) as usize);
        // SAFETY: the pattern is one byte, the range was checked against the buffer.
        unsafe { self.queue.enqueue_fill_buffer(&mut buffer.inner, &[0u8], start, length, &[]) }
            .map_err(|e| self.error(&format!("clearing buffer `{}`", buffer.label), e))?;
        Ok(())
    }

    fn check_size(&self, buffer: &Buffer, bytes: u64) -> Result<(), Error> {
        if bytes > buffer.bytes {
            return Err(Error::Size { buffer: buffer.label.clone(), bytes, size: buffer.bytes });
        }
        Ok(())
    }
}

/// Bytes that the host could still use, as Linux tells; `None` elsewhere.
fn host_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kib = |key: &str| -> Option<u64> {
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
        line.split_whitespace().next()?.parse().ok()
    };
    Some((kib("MemAvailable")? + kib("SwapFree").unwrap_or(0)) * 1024)
}

/// The instructions that the host's processor has, as Linux tells; `None` elsewhere.
pub(super) fn host_instructions() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    text.lines().find(|line| line.starts_with("flags") || line.starts_with("Features")).map(str::to_owned)
}
