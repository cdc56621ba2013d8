//! What holds for every mesh, whoever made it, and the cutting of polygons into triangles.
//!
//! In: meshes. Out: the same, tidied, or an error. It must not know file formats.

use super::Mesh;
use super::error::{Error, MeshFile};
use glam::Vec3;
use std::path::Path;

/// Checks a mesh against the promises of [`Mesh`], and makes its normals unit length or zero.
pub(super) fn tidy(mesh: &mut Mesh, path: &Path) -> Result<(), Error> {
    check(mesh, path)?;
    for normal in &mut mesh.normals {
        *normal = if normal.is_finite() { normal.normalize_or_zero() } else { Vec3::ZERO };
    }
    Ok(())
}

/// The promises of [`Mesh`]: triangles, finite vertices, indices in range, lists of one length.
pub(super) fn check(mesh: &Mesh, path: &Path) -> Result<(), Error> {
    let at = || MeshFile { path: path.to_path_buf(), line: None };
    let vertices = mesh.positions.len();
    let most = vertices.max(mesh.triangles.len());
    if u32::try_from(most).is_err() {
        return Err(Error::TooLarge { at: at(), count: most });
    }
    for (vertex, position) in mesh.positions.iter().enumerate() {
        if !position.is_finite() {
            return Err(Error::NotFinite { at: at(), vertex, value: position.to_array() });
        }
    }
    for (what, count) in [("normals", mesh.normals.len()), ("texture coordinates", mesh.uvs.len())] {
        if count != 0 && count != vertices {
            return Err(Error::LengthMismatch { at: at(), what, count, vertices });
        }
    }
    for data in &mesh.data {
        let count = data.values.len();
        if data.channels == 0 || count as u64 != vertices as u64 * u64::from(data.channels) {
            return Err(Error::LengthMismatch { at: at(), what: "vertex data", count, vertices });
        }
    }
    if mesh.triangles.is_empty() {
        return Err(Error::NoTriangles { at: at() });
    }
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        if let Some(index) = triangle.iter().find(|i| **i as usize >= vertices) {
            let index = i64::from(*index);
            return Err(Error::IndexOutOfRange { at: at(), face, what: "vertex", index, count: vertices, first: 0 });
        }
    }
    Ok(())
}

/// Cuts a convex polygon into a fan around its first vertex.
pub(super) fn fan(polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    for pair in polygon.windows(2).skip(1) {
        triangles.push([polygon[0], pair[0], pair[1]]);
    }
}
