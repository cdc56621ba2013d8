//! A wavefront path tracer in OpenCL that runs OSL materials. See docs/ARCHITECTURE.md for the map.

#![deny(unsafe_op_in_unsafe_fn)]

pub mod assemble;
pub mod device;
pub mod film;
pub mod scene;
