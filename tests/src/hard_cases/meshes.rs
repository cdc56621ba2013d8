//! Meshes that are hard for rays: closed ones with vertices of many edges, needles, flat grids.
//!
//! In: nothing. Out: meshes around the origin. It must not know what is asked of them.

use glam::{Vec2, Vec3};
use oslcl_runtime::scene::Mesh;

/// A mesh without attributes.
pub fn bare(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { name: name.into(), positions, triangles, ..Mesh::default() }
}

/// A closed ball of radius 1 whose poles each join `across` triangles. Every other ring is turned by half a step, so that no two
/// triangles lie in one plane: it stays convex when its corners are rounded.
pub fn ball(across: u32, down: u32) -> Mesh {
    let mut positions = vec![Vec3::Z];
    for j in 1..down {
        for i in 0..across {
            let theta = std::f32::consts::PI * j as f32 / down as f32;
            let phi = 2.0 * std::f32::consts::PI * (i as f32 + 0.5 * (j % 2) as f32) / across as f32;
            positions.push(Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()));
        }
    }
    positions.push(-Vec3::Z);
    let last = positions.len() as u32 - 1;
    let at = |j: u32, i: u32| 1 + (j - 1) * across + i % across;
    let mut triangles = Vec::new();
    for i in 0..across {
        triangles.push([0, at(1, i), at(1, i + 1)]);
        for j in 1..down - 1 {
            let [a, b, c, d] = [at(j, i), at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)];
            triangles.extend(if j % 2 == 0 { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] });
        }
        triangles.push([last, at(down - 1, i + 1), at(down - 1, i)]);
    }
    bare("ball", positions, triangles)
}

/// A closed cube from -1 to 1, each side `n` x `n` squares: its edges run along the axes. Corners are shared by all sides.
pub fn cube(n: u32) -> Mesh {
    let mut positions: Vec<Vec3> = Vec::new();
    let mut triangles = Vec::new();
    let mut place = |p: Vec3| {
        let known = positions.iter().position(|q| *q == p);
        known.unwrap_or_else(|| {
            positions.push(p);
            positions.len() - 1
        }) as u32
    };
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let mut at = |i: u32, j: u32| {
                let step = |k: u32| -1.0 + 2.0 * k as f32 / n as f32;
                let mut p = [side; 3];
                p[(axis + 1) % 3] = step(i);
                p[(axis + 2) % 3] = step(j);
                place(Vec3::from(p))
            };
            for i in 0..n {
                for j in 0..n {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let both = if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    triangles.extend(both);
                }
            }
        }
    }
    bare("cube", positions, triangles)
}

/// A closed ball with needles: rings of triangles a million times longer than wide run over it, and some have no area at all.
pub fn needles() -> Mesh {
    let mut mesh = ball(24, 12);
    mesh.name = "needles".into();
    let mut out = Vec::new();
    for (k, [a, b, c]) in mesh.triangles.iter().enumerate() {
        let [p, q, r] = [a, b, c].map(|i| mesh.positions[*i as usize]);
        // A vertex next to the edge's first end splits off a needle; on the edge itself it splits off nothing.
        let inside = match k % 3 {
            0 => (p * (1.0 - 2e-6) + q * 1e-6 + r * 1e-6).normalize(),
            1 => p * (1.0 / 3.0) + q * (1.0 / 3.0) + r * (1.0 / 3.0),
            _ => p,
        };
        let m = mesh.positions.len() as u32;
        mesh.positions.push(inside);
        out.extend([[*a, *b, m], [*b, *c, m], [*c, *a, m]]);
    }
    mesh.triangles = out;
    mesh
}

/// The square from -1 to 1 in x and z at y = 0, its front towards -y, cut `n` times each way, with texture coordinates.
pub fn grid(n: u32) -> Mesh {
    let mut mesh = bare("grid", Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
            mesh.positions.push(Vec3::new(2.0 * u - 1.0, 0.0, 2.0 * v - 1.0));
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let at = |i: u32, j: u32| j * (n + 1) + i;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}
