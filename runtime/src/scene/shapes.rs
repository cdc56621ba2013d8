//! Meshes made from a few numbers: quad, disk, cube, sphere, and the shapes of `testrender`.
//!
//! In: sizes and segments. Out: meshes around the origin of their object space, or where they are asked for. It must not know files.

use super::{Mesh, geometry};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// A rectangle in the xy plane, front side +z; u along x, v along y.
pub fn quad(size: Vec2) -> Mesh {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from_array);
    Mesh {
        name: "quad".to_string(),
        positions: corners.map(|c| ((c - 0.5) * size).extend(0.0)).to_vec(),
        normals: Vec::new(),
        uvs: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A disk in the xy plane, front side +z; uv as of the square around it. Fewer than 3 `segments` count as 3.
pub fn disk(diameter: f32, segments: u32) -> Mesh {
    let segments = segments.max(3);
    let rim = |i: u32| Vec2::from_angle(TAU * i as f32 / segments as f32) * 0.5;
    let points: Vec<Vec2> = (0..segments).map(rim).collect();
    let mut triangles = Vec::new();
    geometry::fan(&(0..segments).collect::<Vec<_>>(), &mut triangles);
    Mesh {
        name: "disk".to_string(),
        positions: points.iter().map(|p| (*p * diameter).extend(0.0)).collect(),
        normals: Vec::new(),
        uvs: points.iter().map(|p| *p + 0.5).collect(),
        triangles,
        ..Mesh::default()
    }
}

/// A box; uv 0..1 on every side, front sides outwards.
pub fn cube(size: Vec3) -> Mesh {
    let mut mesh = Mesh { name: "cube".to_string(), ..Mesh::default() };
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            // (s, t, normal) is right-handed, so that counter-clockwise is outwards.
            let (mut normal, mut s, mut t) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            normal[axis] = sign;
            s[(axis + 1) % 3] = sign;
            t[(axis + 2) % 3] = 1.0;
            let base = mesh.positions.len() as u32;
            for [u, v] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                mesh.positions.push((normal * 0.5 + s * (u - 0.5) + t * (v - 0.5)) * size);
                mesh.uvs.push(Vec2::new(u, v));
            }
            geometry::fan(&[base, base + 1, base + 2, base + 3], &mut mesh.triangles);
        }
    }
    mesh
}

/// A ball with its axis along z, smooth; u once around from +x by +y, v from the bottom to the top.
/// Fewer than 3 `around` count as 3, fewer than 2 `up` as 2.
pub fn sphere(diameter: f32, around: u32, up: u32) -> Mesh {
    let (around, up) = (around.max(3), up.max(2));
    let mut mesh = Mesh { name: "sphere".to_string(), ..Mesh::default() };
    for j in 0..=up {
        for i in 0..=around {
            // At a pole each triangle has its own vertex, with the u of its middle.
            let pole = j == 0 || j == up;
            let uv = Vec2::new((i as f32 + if pole { 0.5 } else { 0.0 }) / around as f32, j as f32 / up as f32);
            // The seam's columns must coincide to the bit.
            let (sin_phi, cos_phi) = (TAU * (i % around) as f32 / around as f32).sin_cos();
            let (sin_theta, cos_theta) = match pole {
                true => (0.0, if j == 0 { 1.0 } else { -1.0 }),
                false => (TAU * 0.5 * uv.y).sin_cos(),
            };
            let normal = Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, -cos_theta);
            mesh.positions.push(normal * (0.5 * diameter));
            mesh.normals.push(normal);
            mesh.uvs.push(uv);
        }
    }
    let at = |i: u32, j: u32| j * (around + 1) + i;
    for j in 0..up {
        for i in 0..around {
            if j > 0 {
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i + u32::from(j + 1 < up), j + 1)]);
            }
            if j + 1 < up {
                mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    mesh
}

/// A parallelogram of cells x cells from a corner along two edges; front side x cross y, u along x, v along y.
pub fn parallelogram([corner, x, y]: [Vec3; 3], cells: u32) -> Mesh {
    let cells = cells.max(1);
    let mut mesh = Mesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let uv = Vec2::new(i as f32, j as f32) / cells as f32;
            mesh.positions.push(corner + x * uv.x + y * uv.y);
            mesh.uvs.push(uv);
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let at = |di: u32, dj: u32| (j + dj) * (cells + 1) + i + di;
            geometry::fan(&[at(0, 0), at(1, 0), at(1, 1), at(0, 1)], &mut mesh.triangles);
        }
    }
    mesh
}

/// A smooth ball with its axis along y and its rows of vertices half a row from the poles, as the reference's renderer makes it:
/// u once around from -z by -x, v from the top to the bottom.
pub fn rows_sphere(center: Vec3, radius: f32, rows: u32) -> Mesh {
    let (rows, around) = (rows.max(2), 2 * rows.max(2));
    let mut mesh = Mesh::default();
    let mut vertex = |normal: Vec3, uv: Vec2| {
        mesh.positions.push(center + radius * normal);
        mesh.normals.push(normal);
        mesh.uvs.push(uv);
    };
    // At a pole each triangle has its own vertex, with the u of its middle.
    for (y, v) in [(1.0, 0.0), (-1.0, 1.0)] {
        for i in 0..around {
            vertex(Vec3::new(0.0, y, 0.0), Vec2::new((i as f32 + 0.5) / around as f32, v));
        }
    }
    for j in 0..rows {
        let v = (j as f32 + 0.5) / rows as f32;
        let (sin_theta, cos_theta) = (v * TAU * 0.5).sin_cos();
        for i in 0..=around {
            // The seam's columns must coincide to the bit.
            let (sin_phi, cos_phi) = (TAU * (i % around) as f32 / around as f32).sin_cos();
            vertex(
                Vec3::new(-sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi),
                Vec2::new(i as f32 / around as f32, v),
            );
        }
    }
    let at = |i: u32, j: u32| 2 * around + j * (around + 1) + i;
    // Column by column from the seam's left side on, the order of the reference's: it tells lights apart.
    for i in (0..around).map(|i| (i + around - 1) % around) {
        mesh.triangles.push([i, at(i, 0), at(i + 1, 0)]);
        for j in 0..rows - 1 {
            geometry::fan(&[at(i + 1, j), at(i, j), at(i, j + 1), at(i + 1, j + 1)], &mut mesh.triangles);
        }
        mesh.triangles.push([around + i, at(i + 1, rows - 1), at(i, rows - 1)]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area and volume by the divergence theorem: the volume's sign tells which side is the front.
    fn measure(mesh: &Mesh) -> (f32, f32) {
        geometry::check(mesh, std::path::Path::new("shape")).expect("shapes are sound");
        let mut sums = (0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(c - a);
            sums.0 += 0.5 * normal.length();
            sums.1 += a.dot(normal) / 6.0;
        }
        sums
    }

    #[test]
    fn sizes_and_front_sides() {
        let close = |a: f32, b: f32| assert!((a - b).abs() < 0.01 * b.abs().max(0.01), "{a} is not {b}");
        let (area, volume) = measure(&sphere(2.0, 96, 48));
        close(area, 12.566);
        close(volume, 4.18879);
        let (area, volume) = measure(&cube(Vec3::new(1.0, 2.0, 3.0)));
        close(area, 22.0);
        close(volume, 6.0);
        let (area, volume) = measure(&rows_sphere(Vec3::new(1.0, 2.0, 3.0), 1.0, 64));
        close(area, 12.566);
        close(volume, 4.18879);
        close(measure(&quad(Vec2::new(2.0, 3.0))).0, 6.0);
        close(measure(&parallelogram([Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0], 4)).0, 6.0);
        close(measure(&disk(2.0, 64)).0, TAU / 2.0);
        for mesh in [quad(Vec2::ONE), disk(1.0, 8), parallelogram([Vec3::ONE, Vec3::X, Vec3::Y], 2)] {
            let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{} faces down", mesh.name);
        }
    }
}
