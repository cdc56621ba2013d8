//! What the end-to-end tests share.

pub mod exr_file;
pub mod grid;
pub mod points;
