//! Lookups on the host, in f64: what the kernels of kernels/osl/texture*.h must agree with.
//!
//! In: a [`Lookup`]. Out: its channels and their derivatives. Choice of levels, number and weights of samples are those of
//! OpenImageIO's TextureSystem, as in the kernels; it is written for reading, not for speed.

use super::{Entry, Library, Subimage, part};
use oslcl_compiler::textures::{Kind, Lookup, Texel, WRAPS};
use std::f64::consts::PI;

/// Shorter derivatives count as this long.
const TINY: f64 = 1e-8;

/// Longest filter, in lengths of its minor axis.
const ANISOTROPY: f64 = 32.0;

/// Larger texel coordinates are not told apart.
const FAR: f64 = 1e9;

/// How one sample is taken.
#[derive(Clone, Copy, PartialEq)]
enum How {
    Closest,
    Linear,
    Cubic,
}

/// Sums of samples.
#[derive(Clone, Copy, Default)]
struct Sum {
    value: [f64; 3],
    ds: [f64; 3],
    dt: [f64; 3],
    /// Weight of what is not black around the picture.
    covered: f64,
}

impl Sum {
    fn add(&mut self, other: &Sum, weight: f64) {
        for c in 0..3 {
            self.value[c] += other.value[c] * weight;
            self.ds[c] += other.ds[c] * weight;
            self.dt[c] += other.dt[c] * weight;
        }
        self.covered += other.covered * weight;
    }
}

/// A lookup's picture and options.
struct Source<'a> {
    sub: &'a Subimage,
    wraps: [i32; 2],
    first: usize,
    actual: usize,
    /// Environments: colours of the poles take over near them.
    poles: bool,
}

/// Carries a lookup out.
pub fn lookup(library: &Library, l: &Lookup<'_>) -> Texel {
    let mut st = [l.at[0], l.at[1]];
    if l.kind != Kind::Texture {
        st = [0.0; 2];
    }
    let entry = library.picture_at(l.file, &mut st);
    let sub = match entry.as_deref() {
        Ok(Entry::File(picture)) => part(picture, l.subimage, l.subimage_name),
        _ => None,
    };
    let Some(sub) = sub else {
        return Texel { value: l.missing.unwrap_or([l.fill; 3]), ..Texel::default() };
    };
    let wrap = |axis: usize| match l.wraps[axis] {
        0 => sub.wraps()[axis] as i32,
        mode => mode,
    };
    let first = l.first_channel.max(0) as usize;
    let mut source = Source {
        sub,
        wraps: [wrap(0), wrap(1)],
        first,
        actual: sub.channels.saturating_sub(first).min(l.channels as usize),
        poles: false,
    };
    match l.kind {
        Kind::Texture => source.plane(st, l),
        Kind::Volume => source.volume(l),
        Kind::Environment => {
            // 6 and 3: WRAPS.
            source.wraps = [if sub.has_border() { 6 } else { 3 }, 2];
            source.poles = true;
            Texel { value: source.direction(l), ..Texel::default() }
        }
    }
}

/// Moves a texel coordinate into `0..size`; `None`: black lies there.
fn wrap(mode: i32, i: i64, size: u32) -> Option<usize> {
    let size = i64::from(size);
    let inside = match WRAPS[mode.clamp(0, 6) as usize] {
        "clamp" => i.clamp(0, size - 1),
        "periodic" | "periodic_pow2" => i.rem_euclid(size),
        "mirror" => {
            let i = if i < 0 { -i - 1 } else { i };
            if (i / size) % 2 == 1 { size - 1 - i % size } else { i % size }
        }
        "periodic_sharedborder" => i.rem_euclid((size - 1).max(1)),
        _ if (0..size).contains(&i) => i,
        _ => return None,
    };
    Some(inside as usize)
}

/// The texel before a coordinate, and how far it lies behind that one.
fn floor(x: f64) -> (i64, f64) {
    let whole = x.floor();
    let rest = x - whole;
    (whole.clamp(-FAR, FAR) as i64, if (0.0..=1.0).contains(&rest) { rest } else { 0.0 })
}

/// Weights of the uniform cubic B-spline and their derivatives.
fn spline(f: f64) -> ([f64; 4], [f64; 4]) {
    let g = 1.0 - f;
    let w =
        [g * g * g / 6.0, 2.0 / 3.0 - f * f * (2.0 - f) / 2.0, 2.0 / 3.0 - g * g * (2.0 - g) / 2.0, f * f * f / 6.0];
    (w, [-g * g / 2.0, f * (3.0 * f - 4.0) / 2.0, -g * (3.0 * g - 4.0) / 2.0, f * f / 2.0])
}

impl Source<'_> {
    fn size(&self, level: usize) -> (u32, u32) {
        (self.sub.levels[level].width, self.sub.levels[level].height)
    }

    fn texel(&self, level: usize, x: usize, y: usize) -> [f64; 3] {
        let l = &self.sub.levels[level];
        let at = (y * l.width as usize + x) * self.sub.channels + self.first;
        [0, 1, 2].map(|c| if c < self.actual { l.texels.get(at + c) } else { 0.0 })
    }

    /// Texel coordinates of s and t.
    fn place(&self, level: usize, [s, t]: [f64; 2]) -> [f64; 2] {
        let (width, height) = self.size(level);
        if self.sub.has_border() {
            [s * f64::from(width - 1), t * f64::from(height - 1)]
        } else {
            [s * f64::from(width) - 0.5, t * f64::from(height) - 0.5]
        }
    }

    /// One sample.
    fn sample(&self, how: How, level: usize, st: [f64; 2], mut weight: f64, sum: &mut Sum) {
        let [(i, u), (j, v)] = self.place(level, st).map(floor);
        if how == How::Closest {
            let (width, height) = self.size(level);
            let x = wrap(self.wraps[0], i + i64::from(u > 0.5), width);
            let y = wrap(self.wraps[1], j + i64::from(v > 0.5), height);
            if let (Some(x), Some(y)) = (x, y) {
                sum.add(&Sum { value: self.texel(level, x, y), covered: 1.0, ..Sum::default() }, weight);
            }
            return;
        }
        if self.poles {
            self.pole(level, st[1], &mut weight, sum);
        }
        if how == How::Linear {
            let slope = [-1.0, 1.0];
            self.weighted(level, [i, j], (&[1.0 - u, u], &slope), (&[1.0 - v, v], &slope), weight, sum);
        } else {
            let ((wx, dx), (wy, dy)) = (spline(u), spline(v));
            self.weighted(level, [i - 1, j - 1], (&wx, &dx), (&wy, &dy), weight, sum);
        }
    }

    /// Texels from a corner on, by weights and derivatives of columns and rows.
    fn weighted(
        &self,
        level: usize,
        corner: [i64; 2],
        (wx, dx): (&[f64], &[f64]),
        (wy, dy): (&[f64], &[f64]),
        weight: f64,
        sum: &mut Sum,
    ) {
        let (width, height) = self.size(level);
        for (j, (wy, dy)) in wy.iter().zip(dy).enumerate() {
            let Some(y) = wrap(self.wraps[1], corner[1] + j as i64, height) else { continue };
            for (i, (wx, dx)) in wx.iter().zip(dx).enumerate() {
                let Some(x) = wrap(self.wraps[0], corner[0] + i as i64, width) else { continue };
                let texel = self.texel(level, x, y);
                for (c, x) in texel.iter().enumerate() {
                    sum.value[c] += x * weight * wx * wy;
                    sum.ds[c] += x * weight * f64::from(width) * dx * wy;
                    sum.dt[c] += x * weight * f64::from(height) * wx * dy;
                }
                sum.covered += weight * wx * wy;
            }
        }
    }

    /// Near a pole of a level of one tile the mean of the outermost row takes over.
    fn pole(&self, level: usize, t: f64, weight: &mut f64, sum: &mut Sum) {
        if !self.sub.is_one_tile(level) {
            return;
        }
        let rows = self.size(level).1;
        let height = f64::from(rows - u32::from(self.sub.has_border()));
        let row = t * height;
        if !(row < 1.0 || row > height - 1.0) {
            return;
        }
        let near = if row < 1.0 { 1.0 - row } else { row - row.floor() }.clamp(0.0, 1.0);
        let color = self.sub.row_mean(level, if row < 1.0 { 0 } else { rows - 1 });
        for c in 0..self.actual {
            sum.value[c] += color[self.first + c] * *weight * near * near;
        }
        *weight *= 1.0 - near * near;
    }

    /// The two levels around a filter of these sizes in texels, the share of the second, and whether even the finest is too
    /// coarse.
    fn levels(&self, texels: impl Fn(usize) -> f64) -> ([usize; 2], f64, bool) {
        let count = self.sub.levels.len();
        match (0..count).find(|m| texels(*m) <= 1.0) {
            None => ([count - 1; 2], 0.0, false),
            Some(0) => ([0; 2], 0.0, true),
            Some(m) => ([m - 1, m], (2.0 * texels(m) - 1.0).clamp(0.0, 1.0), false),
        }
    }

    fn how(&self, interp: i32, smart_cubic: bool) -> How {
        match interp {
            3 => How::Closest,
            2 => How::Linear,
            1 => How::Cubic,
            _ if smart_cubic => How::Cubic,
            _ => How::Linear,
        }
    }

    fn filled(&self, sum: &Sum, fill: f64) -> [f64; 3] {
        [0, 1, 2].map(|c| if c < self.actual { sum.value[c] } else { sum.covered * fill })
    }

    fn plane(&self, st: [f64; 2], l: &Lookup<'_>) -> Texel {
        let [sscale, soffset, tscale, toffset] = self.sub.placement().map(f64::from);
        let st = [st[0] * sscale + soffset, st[1] * tscale + toffset];
        let dx = [l.dx[0] * sscale, l.dx[1] * tscale];
        let dy = [l.dy[0] * sscale, l.dy[1] * tscale];
        let natural = [0, 1].map(|k| (1.0 / dx[k].abs().max(dy[k].abs()).max(TINY)) as i64);
        let mut e = Ellipse::new(dx, dy, l.width, l.blur);
        let side = |m: usize| f64::from(self.size(m).0.min(self.size(m).1));
        let (levels, share, finest) = self.levels(|m| e.minor * side(m));
        if finest {
            let full = f64::from(self.sub.full[2].max(self.sub.full[3]).max(1));
            if e.minor * full < 0.5 {
                e.aspect = (e.major * full * 2.0).clamp(1.0, ANISOTROPY);
            }
        }
        let mut sum = Sum::default();
        for (level, share) in levels.into_iter().zip([1.0 - share, share]) {
            if share == 0.0 {
                continue;
            }
            let (width, height) = self.size(level);
            let magnified = i64::from(width) < natural[0] / 2 || i64::from(height) < natural[1] / 2;
            let how = self.how(l.interp, level == 0 || magnified);
            sum.add(&self.along(how, level, st, &e), share);
        }
        let by = [sum.ds.map(|x| x * sscale), sum.dt.map(|x| x * tscale), [0.0; 3]];
        Texel { value: self.filled(&sum, l.fill), by }
    }

    /// Samples of one level along an ellipse, their weights adding up to 1.
    fn along(&self, how: How, level: usize, [s, t]: [f64; 2], e: &Ellipse) -> Sum {
        let count = ((2.0 * e.aspect - 1.0) as i32).max(1);
        let reach = e.major - e.minor;
        let scale = if count > 2 { e.major / (2.0 * reach) } else { 0.0 };
        let (mut sum, mut total) = (Sum::default(), 0.0);
        for i in 0..count {
            let place = 2.0 * (f64::from(i) + 0.5) / f64::from(count) - 1.0;
            let weight = (-2.0 * (place * scale) * (place * scale)).exp();
            let at = [s + place * reach * e.along[0], t + place * reach * e.along[1]];
            self.sample(how, level, at, weight, &mut sum);
            total += weight;
        }
        let mut mean = Sum::default();
        mean.add(&sum, 1.0 / total);
        mean
    }

    fn volume(&self, l: &Lookup<'_>) -> Texel {
        let [sscale, soffset, tscale, toffset] = self.sub.placement().map(f64::from);
        let (width, height) = self.size(0);
        let column = (l.at[0] * sscale + soffset) * f64::from(width);
        let row = (l.at[1] * tscale + toffset) * f64::from(height);
        let inside = |slice: i64| f64::from(u8::from(wrap(l.wraps[2], slice, 1).is_some()));
        let mut sum = Sum::default();
        if l.interp == 3 {
            let [i, j, k] = [column, row, l.at[2]].map(|x| floor(x).0);
            let (x, y) = (wrap(self.wraps[0], i, width), wrap(self.wraps[1], j, height));
            if let (Some(x), Some(y), true) = (x, y, inside(k) > 0.0) {
                sum = Sum { value: self.texel(0, x, y), covered: 1.0, ..Sum::default() };
            }
            return Texel { value: self.filled(&sum, l.fill), ..Texel::default() };
        }
        let [(i, u), (j, v), (k, w)] = [column, row, l.at[2]].map(|x| floor(x - 0.5));
        let slope = [-1.0, 1.0];
        let (before, behind) = (inside(k), inside(k + 1));
        self.weighted(0, [i, j], (&[1.0 - u, u], &slope), (&[1.0 - v, v], &slope), 1.0, &mut sum);
        let weight = before * (1.0 - w) + behind * w;
        let (dr, sum) = (sum.value.map(|x| x * (behind - before)), {
            let mut scaled = Sum::default();
            scaled.add(&sum, weight);
            scaled
        });
        let by = [sum.ds.map(|x| x * sscale), sum.dt.map(|x| x * tscale), dr];
        Texel { value: self.filled(&sum, l.fill), by }
    }

    fn direction(&self, l: &Lookup<'_>) -> [f64; 3] {
        let plus = |a: [f64; 3], b: [f64; 3], k: f64| [0, 1, 2].map(|i| a[i] + k * b[i]);
        let (r, rx, ry) = (unit(l.at), unit(plus(l.at, l.dx, 1.0)), unit(plus(l.at, l.dy, 1.0)));
        let angles = [angle(r, rx).max(TINY), angle(r, ry).max(TINY)];
        let natural = (PI / angles[0].min(angles[1])) as i64;
        let sizes = [0, 1].map(|k| angles[k] * l.width[k] + l.blur[k]);
        let along = if sizes[0] >= sizes[1] { rx } else { ry };
        let (mut major, mut minor) = (sizes[0].max(sizes[1]), sizes[0].min(sizes[1]));
        let aspect = limit_aspect(&mut major, &mut minor);
        let count = ((aspect - 0.25).ceil() as i32).max(1);
        let (levels, share, _) = self.levels(|m| f64::from(self.size(m).1) * minor / PI);
        let mut sum = Sum::default();
        for i in 0..count {
            let place = (f64::from(i) + 0.5) / f64::from(count) - 0.5;
            let st = self.of_direction(plus(r, along, place));
            for (level, share) in levels.into_iter().zip([1.0 - share, share]) {
                if share == 0.0 {
                    continue;
                }
                let how = self.how(l.interp, level == 0 || i64::from(self.size(level).1) < natural / 2);
                self.sample(how, level, st, share / f64::from(count), &mut sum);
            }
        }
        self.filled(&sum, l.fill)
    }

    fn of_direction(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let (a, b, up) = if self.sub.y_is_up() { (-x, z, y) } else { (y, x, z) };
        let st = [a.atan2(b) / (2.0 * PI) + 0.5, 0.5 - up.atan2(a.hypot(b)) / PI];
        st.map(|c| if c.is_finite() { c } else { 0.0 })
    }
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { v.map(|x| x / length) } else { [0.0; 3] }
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    cross.iter().map(|x| x * x).sum::<f64>().sqrt().atan2(dot)
}

/// The ratio of a filter's axes; one that is too long is made a little shorter along and a little longer across.
fn limit_aspect(major: &mut f64, minor: &mut f64) -> f64 {
    let aspect = (*major / *minor).clamp(1.0, 1e6);
    if aspect <= ANISOTROPY {
        return aspect;
    }
    *major = 0.5 * (*major + *minor * ANISOTROPY);
    *minor = *major / ANISOTROPY;
    ANISOTROPY
}

/// The filter: an ellipse in texture coordinates.
struct Ellipse {
    major: f64,
    minor: f64,
    /// Unit, along the major axis.
    along: [f64; 2],
    aspect: f64,
}

impl Ellipse {
    fn new(dx: [f64; 2], dy: [f64; 2], width: [f64; 2], blur: [f64; 2]) -> Ellipse {
        let mut x = [dx[0] * width[0], dx[1] * width[1]];
        let mut y = [dy[0] * width[0], dy[1] * width[1]];
        let square = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
        let (xx, yy) = (square(x), square(y));
        if xx < TINY * TINY && yy < TINY * TINY {
            (x, y) = ([TINY, 0.0], [0.0, TINY]);
        } else if xx < TINY * TINY {
            x = [y[1], -y[0]].map(|c| c * TINY / yy.sqrt());
        } else if yy < TINY * TINY {
            y = [-x[1], x[0]].map(|c| c * TINY / xx.sqrt());
        }
        let a = x[1] * x[1] + y[1] * y[1];
        let b = -2.0 * (x[0] * x[1] + y[0] * y[1]);
        let c = x[0] * x[0] + y[0] * y[0];
        let longest = if b == 0.0 { a.max(c).sqrt() } else { ((a + c + (a - c).hypot(b)) / 2.0).sqrt() };
        let mut major = longest.min(1000.0);
        let shortest = if b == 0.0 { a.min(c).sqrt() } else { (x[0] * y[1] - x[1] * y[0]).abs() / longest };
        let mut minor = shortest.min(major);
        let theta = 0.5 * b.atan2(a - c) + PI / 2.0;
        let mut along = [theta.cos(), theta.sin()];
        if blur[0] + blur[1] != 0.0 {
            major += (blur[0] * along[0]).hypot(blur[1] * along[1]);
            minor += (blur[0] * along[1]).hypot(blur[1] * along[0]);
            if minor > major {
                (major, minor) = (minor, major);
                along = [-along[1], along[0]];
            }
        }
        let aspect = limit_aspect(&mut major, &mut minor);
        Ellipse { major, minor, along, aspect }
    }
}
