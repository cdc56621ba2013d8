//! What the end-to-end tests share.

pub mod bsdf;
pub mod scenes;
