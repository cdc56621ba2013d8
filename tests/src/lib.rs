//! What the end-to-end tests share.

pub mod bsdf;
pub mod grid;
pub mod hard_cases;
pub mod pictures;
pub mod points;
pub mod scenes;
