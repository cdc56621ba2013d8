//! A wavefront path tracer in OpenCL that runs OSL materials. See docs/ARCHITECTURE.md for the map.

#![deny(unsafe_op_in_unsafe_fn)]

pub mod accel;
pub mod accuracy;
pub mod adaptive;
pub mod assemble;
mod attributes;
pub mod builders;
pub mod cache;
pub mod choices;
pub mod device;
pub mod displace;
pub mod explain;
pub mod files;
pub mod film;
pub mod grid;
pub mod materials;
pub mod measure;
pub mod package;
pub mod plan;
pub mod points;
mod preamble;
pub mod precision;
pub mod programs;
pub mod render;
pub mod roads;
pub mod scene;
pub mod session;
pub mod shade;
pub mod shader_file;
pub mod shader_group;
pub mod study;
mod supplies;
pub mod target;
pub mod textures;
pub mod told;
mod traced;
mod vertex_data;
pub mod wavefront;
