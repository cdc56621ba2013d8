//! What the interpreter asks about point clouds. The crate does no IO, so a trait answers.
//!
//! In: names of files as shaders write them. Out: points near a place, and what is known of them. Whoever implements
//! [`PointClouds`] finds and reads the files.

/// What a point has of one attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Whole numbers.
    Ints(Vec<i32>),
    /// Numbers.
    Floats(Vec<f64>),
    /// A color, point, vector or normal.
    Triple([f64; 3]),
    /// A string.
    Text(String),
}

/// Answers questions about point clouds. Files that cannot be read have no points.
pub trait PointClouds: Send + Sync {
    /// The points within a radius, at most so many, the closest ones: index and distance, by distance, then by index.
    fn search(&self, file: &str, center: [f64; 3], radius: f64, most: usize) -> Vec<(i32, f64)>;
    /// An attribute of a point; `None` where there is none.
    fn get(&self, file: &str, point: i32, attribute: &str) -> Option<Values>;
}
