//! Which edges of a mesh's triangles are flat, so that points beside them need not be kept clear of a wall.
//!
//! In: a mesh. Out: three bits a triangle, as kernels/surface.h reads them. It must not know trees or instances.

use crate::scene::Mesh;

/// For each triangle, a bit for each corner whose opposite edge is shared with the triangle before or behind it in the same plane, as
/// the halves of a quadrilateral share their diagonal. Other flat edges are not looked for.
pub fn flat(mesh: &Mesh) -> Vec<u32> {
    // Corners are rounded to f32: a quadrilateral's halves may be 1e-7 out of plane.
    const SAME_PLANE: f64 = 1.0 - 1e-12;
    let at = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize].as_dvec3());
    let mut flat = vec![0; mesh.triangles.len()];
    let mut before = None;
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        let here @ [a, b, c] = at(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if let Some((other, other_normal)) = before.replace((here, normal))
            && normal.dot(other_normal) > SAME_PLANE
        {
            // Neighbours pass the edge in opposite directions; else both lie on the same side of it.
            let shared =
                |i: usize, j: usize| here[(i + 1) % 3] == other[(j + 2) % 3] && here[(i + 2) % 3] == other[(j + 1) % 3];
            for (i, j) in (0..9).map(|n| (n / 3, n % 3)).filter(|(i, j)| shared(*i, *j)) {
                flat[k] |= 1 << i;
                flat[k - 1] |= 1 << j;
            }
        }
    }
    flat
}

#[cfg(test)]
mod tests {
    use super::flat;
    use crate::scene::Mesh;
    use glam::{Quat, Vec3};

    /// Corners of a unit square, and one that leaves its plane by `rise`.
    fn mesh(rise: f32, triangles: &[[u32; 3]]) -> Mesh {
        let turn = Quat::from_rotation_x(0.3) * Quat::from_rotation_z(0.7);
        let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, rise), Vec3::Y, Vec3::ZERO];
        Mesh { positions: corners.map(|p| turn * p).to_vec(), triangles: triangles.to_vec(), ..Mesh::default() }
    }

    #[test]
    fn halves_of_a_quadrilateral_share_a_flat_edge() {
        assert_eq!(flat(&mesh(0.0, &[[0, 1, 2], [0, 2, 3]])), [0b010, 0b100]);
        assert_eq!(flat(&mesh(0.0, &[[1, 2, 0], [3, 0, 2]])), [0b001, 0b001]);
        // By places, not by indices: corner 4 lies on corner 0.
        assert_eq!(flat(&mesh(0.0, &[[0, 1, 2], [4, 2, 3]])), [0b010, 0b100]);
    }

    #[test]
    fn folds_and_coincident_triangles_are_not_flat() {
        assert_eq!(flat(&mesh(1e-3, &[[0, 1, 2], [0, 2, 3]])), [0, 0]);
        assert_eq!(flat(&mesh(0.0, &[[0, 1, 2], [0, 1, 2]])), [0, 0]);
        // The back of the neighbour's plane, the same side of the edge, and triangles without area.
        assert_eq!(flat(&mesh(0.0, &[[0, 1, 2], [0, 3, 2]])), [0, 0]);
        assert_eq!(flat(&mesh(0.0, &[[0, 1, 2], [0, 1, 3]])), [0, 0]);
        assert_eq!(flat(&mesh(0.0, &[[0, 1, 2], [0, 2, 4]])), [0, 0]);
    }
}
