//! Points to evaluate shaders at: the grid of the reference's `testshade`, and pools of arguments for single functions.
//!
//! All numbers are 32-bit floats, so that every precision starts from the same.

use oslcl_compiler::interp::{Globals, Space};

/// A point of `testshade`'s plane: P = (u, v, 1), N = (0, 0, 1), dPdu and dPdv along x and y.
pub fn plane(u: f32, v: f32) -> Globals {
    let (u, v) = (f64::from(u), f64::from(v));
    Globals {
        p: [u, v, 1.0],
        n: [0.0, 0.0, 1.0],
        ng: [0.0, 0.0, 1.0],
        u,
        v,
        dpdu: [1.0, 0.0, 0.0],
        dpdv: [0.0, 1.0, 0.0],
        ..Globals::default()
    }
}

/// A grid of n x n points of the plane, row by row, with some state and two spaces on top.
pub fn grid(n: u32) -> Vec<Globals> {
    // Both are exact in binary, and so are their inverses.
    let object = [0., 1., 0., 0., -1., 0., 0., 0., 0., 0., 2., 0., 0.5, -3., 1., 1.];
    let from_object = [0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 0.5, 0., 3., 0.5, -0.5, 1.];
    let camera = [1., 0., 0., 0., 0., 0., 1., 0., 0., -1., 0., 0., 2., 4., -1., 1.];
    let from_camera = [1., 0., 0., 0., 0., 0., -1., 0., 0., 1., 0., 0., -2., -1., -4., 1.];
    let mut points = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let last = (n - 1).max(1) as f32;
            let mut g = plane(x as f32 / last, y as f32 / last);
            g.i = [0.0, 0.0, -1.0];
            g.time = 0.25 * f64::from(x);
            g.dtime = 0.5;
            g.surfacearea = 2.5;
            g.du = [0.125, -0.25];
            g.dv = [0.0625 * f64::from(x), 0.5];
            g.dp = [[0.25, 0.5 * g.u, -0.125], [g.v - 0.5, 0.75, 0.0625]];
            g.di = [[0.5, 0.0, 0.25], [0.0, -0.5, g.u]];
            g.dps = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
            g.flip_handedness = x % 3 == 1;
            g.backfacing = (x + y) % 2 == 1;
            g.raytype = (1 << (x % 6)) | (1 << (y % 6));
            g.object_space = Space { to_common: object, from_common: from_object };
            g.shader_space = Space { to_common: from_camera, from_common: camera };
            g.camera_space = Space { to_common: camera, from_common: from_camera };
            points.push(g);
        }
    }
    points
}

/// Numbers that functions trip over, and a few plain ones. Their squares are finite floats. See also [`Reach`].
const SPECIAL: [f32; 16] =
    [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.25, 1e-6, -1e-6, 1e-12, 3e15, -3e15, 1000.0, -7.0, 0.99999994];

/// How large the special numbers get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// 3e15: for functions of single numbers.
    Wide,
    /// 64: where products of several arguments cancel, or lattice cells are numbered with ints.
    Narrow,
}

/// A small generator (Marsaglia's xorshift): the same points in each run.
struct Random(u32);

impl Random {
    fn next(&mut self, low: f32, high: f32) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        f64::from(low + (high - low) * (self.0 >> 8) as f32 / 16_777_216.0)
    }
}

/// Pools of arguments: every global that a shader can read holds numbers of its own. `special` points mix the special
/// numbers, `random` ones come from several ranges.
pub fn pools(special: usize, random: usize, reach: Reach) -> Vec<Globals> {
    let mut rng = Random(0x9e37_79b9);
    let mut points = Vec::new();
    for k in 0..special + random {
        let (low, high) = [(-1.0, 1.0), (0.0, 1.0), (-10.0, 10.0), (0.5, 4.0), (-300.0, 300.0)][k % 5];
        let mut slot = 0;
        let mut number = || {
            slot += 1;
            // The first sixteen points pass every special number through the first slots; later ones pair them.
            let pick = (k + (slot - 1) * (1 + k / SPECIAL.len())) % SPECIAL.len();
            let number = f64::from(SPECIAL[pick]);
            let number = if reach == Reach::Narrow { number.clamp(-64.0, 64.0) } else { number };
            if k < special { number } else { rng.next(low, high) }
        };
        let (u, v, time, dtime) = (number(), number(), number(), number());
        let mut triple = || [number(), number(), number()];
        let g = Globals { p: triple(), i: triple(), n: triple(), ng: triple(), dpdu: triple(), ..Globals::default() };
        let g = Globals { dpdv: triple(), ps: triple(), dpdtime: triple(), u, v, time, dtime, ..g };
        let mut slope = || rng.next(-1.0, 1.0);
        let (du, dv) = ([slope(), slope()], [slope(), slope()]);
        let mut pair = || [[slope(), slope(), slope()], [slope(), slope(), slope()]];
        points.push(Globals { dp: pair(), di: pair(), dps: pair(), du, dv, flip_handedness: k % 2 == 1, ..g });
    }
    points
}
