//! The derivatives of geometric and colour functions (specification ch. 7.2, 7.3).
//!
//! In: a call's value and its arguments. Out: its derivatives. Matrices have none, as in the reference implementation; a
//! rotation's angle and axis do. Formulas are those of kernels/osl/, in dual numbers.

use super::Rewriter;
use super::dual::{Dual, Slope};
use crate::ir::{BinaryOp, Inst, Ty, ValueId};

impl Rewriter {
    /// Rows that do not work component by component.
    pub(super) fn geometric(&mut self, name: &str, v: ValueId, args: &[Dual]) -> Slope {
        match (name, args) {
            ("erf", [x]) => {
                let slope = self.gaussian(x.v);
                self.scale(slope, x.d)
            }
            ("erfc", [x]) => {
                let slope = self.gaussian(x.v);
                let d = self.scale(slope, x.d);
                self.neg_slope(d)
            }
            ("hypot", parts) => {
                let mut sum = None;
                for x in parts {
                    let d = self.scale(x.v, x.d);
                    sum = self.add_slopes(sum, d);
                }
                self.divide(sum, v)
            }
            ("dot", [a, b]) => {
                let left = self.each("dot", Ty::Float, b.v, a.d);
                let right = self.each("dot", Ty::Float, a.v, b.d);
                self.add_slopes(left, right)
            }
            ("cross", [a, b]) => {
                let left = a.d.map(|d| d.map(|d| self.plain("cross", &[d, b.v], Ty::Triple)));
                let right = self.each("cross", Ty::Triple, a.v, b.d);
                self.add_slopes(left, right)
            }
            ("length", [a]) => {
                let d = self.each("dot", Ty::Float, a.v, a.d);
                self.divide(d, v)
            }
            ("normalize", [a]) => {
                let length = self.plain("length", &[a.v], Ty::Float);
                let along = self.each("dot", Ty::Float, v, a.d);
                let along = along.map(|d| d.map(|d| self.value(Inst::Convert(d), Ty::Triple)));
                let along = self.scale(v, along);
                let across = self.sub_slopes(a.d, along);
                let length = self.value(Inst::Convert(length), Ty::Triple);
                self.divide(across, length)
            }
            ("distance", [a, b]) => {
                let difference = self.sub(*a, *b);
                self.f("length", &[difference], Ty::Float).d
            }
            ("distance", [a, b, q]) => self.distance_to_segment(*a, *b, *q),
            ("faceforward_ref", [n, i, reference]) => {
                let cosine = self.plain("dot", &[i.v, reference.v], Ty::Float);
                let zero = self.constant(0.0, Ty::Float).v;
                let away = self.binary(BinaryOp::Gt, cosine, zero);
                let turned = self.neg_slope(n.d);
                self.pick_slope(away, turned, n.d, Ty::Triple)
            }
            ("reflect", [i, n]) => self.reflect(*i, *n).d,
            ("refract", [i, n, eta]) => self.refract(*i, *n, *eta).d,
            ("rotate", [p, angle, axis]) => {
                let origin = self.constant(0.0, Ty::Triple);
                self.rotate(*p, *angle, origin, *axis)
            }
            ("rotate", [p, angle, a, b]) => self.rotate(*p, *angle, *a, *b),
            ("transform_point", [m, p]) => self.transform_point(m.v, v, *p),
            ("transform_vector" | "transform_normal", [m, a]) => self.each(name, Ty::Triple, m.v, a.d),
            ("luminance", [c]) => c.d.map(|d| d.map(|d| self.plain(name, &[d], Ty::Float))),
            // Linear.
            ("yiq_to_rgb" | "rgb_to_yiq" | "xyz_to_rgb" | "rgb_to_xyz", [c]) => {
                c.d.map(|d| d.map(|d| self.plain(name, &[d], Ty::Triple)))
            }
            ("xyy_to_rgb", [c]) => self.xyy_to_rgb(*c),
            ("rgb_to_xyy", [c]) => self.rgb_to_xyy(*c),
            ("hsv_to_rgb", [c]) => self.hsv_to_rgb(*c).d,
            ("hsl_to_rgb", [c]) => self.hsl_to_rgb(*c).d,
            ("rgb_to_hsv", [c]) => self.rgb_to_hsv(*c).d,
            ("rgb_to_hsl", [c]) => self.rgb_to_hsl(*c),
            ("srgb_to_rgb" | "rgb_to_srgb", [c]) => {
                let slope = self.slope_of_srgb(name, c.v);
                self.scale(slope, c.d)
            }
            _ => None,
        }
    }

    /// A function that is linear in its second argument, of each derivative.
    fn each(&mut self, name: &str, ty: Ty, first: ValueId, d: Slope) -> Slope {
        d.map(|d| d.map(|d| self.plain(name, &[first, d], ty)))
    }

    fn dot(&mut self, a: Dual, b: Dual) -> Dual {
        self.f("dot", &[a, b], Ty::Float)
    }

    fn number(&mut self, c: f64) -> Dual {
        self.constant(c, Ty::Float)
    }

    fn distance_to_segment(&mut self, a: Dual, b: Dual, q: Dual) -> Slope {
        let along = self.sub(b, a);
        let to_q = self.sub(q, a);
        let (top, bottom) = (self.dot(to_q, along), self.dot(along, along));
        let t = self.div(top, bottom);
        let (zero, one) = (self.number(0.0), self.number(1.0));
        let t = self.f("clamp", &[t, zero, one], Ty::Float);
        let step = self.times(along, t);
        let nearest = self.add(a, step);
        self.f("distance", &[q, nearest], Ty::Float).d
    }

    fn reflect(&mut self, i: Dual, n: Dual) -> Dual {
        let cosine = self.dot(n, i);
        let twice = self.linear(cosine, 2.0, 0.0);
        let step = self.times(n, twice);
        self.sub(i, step)
    }

    fn refract(&mut self, i: Dual, n: Dual, eta: Dual) -> Dual {
        let cosine = self.dot(i, n);
        let one = self.number(1.0);
        let square = self.mul(cosine, cosine);
        let sine2 = self.sub(one, square);
        let eta2 = self.mul(eta, eta);
        let product = self.mul(eta2, sine2);
        let k = self.sub(one, product);
        let zero = self.number(0.0).v;
        let beyond = self.binary(BinaryOp::Lt, k.v, zero);
        let root = self.f("sqrt", &[k], Ty::Float);
        let scaled = self.mul(eta, cosine);
        let sum = self.add(scaled, root);
        let (left, right) = (self.times(i, eta), self.times(n, sum));
        let direction = self.sub(left, right);
        let none = self.constant(0.0, Ty::Triple);
        self.pick(beyond, none, direction)
    }

    /// Of Kr, Kt, R, T.
    pub(super) fn fresnel(&mut self, i: Dual, n: Dual, eta: Dual) -> Vec<Slope> {
        let one = self.number(1.0);
        let cosine = self.dot(i, n);
        let c = self.f("fabs", &[cosine], Ty::Float);
        let eta2 = self.mul(eta, eta);
        let inverse = self.div(one, eta2);
        let c2 = self.mul(c, c);
        let g2 = self.add(inverse, c2);
        let g2 = self.linear(g2, 1.0, -1.0);
        let zero = self.number(0.0).v;
        let beyond = self.binary(BinaryOp::Lt, g2.v, zero);
        let g = self.f("sqrt", &[g2], Ty::Float);
        let (less, more) = (self.sub(g, c), self.add(g, c));
        let (top, bottom) = (self.mul(c, more), self.mul(c, less));
        let (top, bottom) = (self.linear(top, 1.0, -1.0), self.linear(bottom, 1.0, 1.0));
        let p = self.div(top, bottom);
        let p2 = self.mul(p, p);
        let mean = self.linear(p2, 0.5, 0.5);
        let s = self.div(less, more);
        let s2 = self.mul(s, s);
        let kr = self.mul(mean, s2);
        let kr = self.pick(beyond, one, kr);
        let rest = self.sub(one, kr);
        let kt = self.mul(rest, eta2);
        let (r, t) = (self.reflect(i, n), self.refract(i, n, eta));
        vec![kr.d, kt.d, r.d, t.d]
    }

    /// Rodrigues' formula, as the kernel has it.
    fn rotate(&mut self, p: Dual, angle: Dual, a: Dual, b: Dual) -> Slope {
        let direction = self.sub(b, a);
        let axis = self.f("normalize", &[direction], Ty::Triple);
        let arm = self.sub(p, a);
        let (sin, cos) = (self.f("sin", &[angle], Ty::Float), self.f("cos", &[angle], Ty::Float));
        let part = self.times(arm, cos);
        let side = self.f("cross", &[axis, arm], Ty::Triple);
        let side = self.times(side, sin);
        let along = self.dot(axis, arm);
        let one = self.number(1.0);
        let rest = self.sub(one, cos);
        let along = self.mul(along, rest);
        let along = self.times(axis, along);
        let sum = self.add(part, side);
        let sum = self.add(sum, along);
        self.add(sum, a).d
    }

    /// v = (p M) / w: the derivative of a quotient.
    fn transform_point(&mut self, m: ValueId, v: ValueId, p: Dual) -> Slope {
        let column: Vec<ValueId> = (0..4)
            .map(|row| {
                let (row, three) = (self.int(row), self.int(3));
                self.value(Inst::MatrixElement(m, row, three), Ty::Float)
            })
            .collect();
        let direction = self.value(Inst::Triple([column[0], column[1], column[2]]), Ty::Triple);
        let product = self.plain("dot", &[p.v, direction], Ty::Float);
        let w = self.binary(BinaryOp::Add, product, column[3]);
        let w = self.value(Inst::Convert(w), Ty::Triple);
        let top = self.each("transform_vector", Ty::Triple, m, p.d);
        let by_w = self.each("dot", Ty::Float, direction, p.d);
        let by_w = by_w.map(|d| d.map(|d| self.value(Inst::Convert(d), Ty::Triple)));
        let by_w = self.scale(v, by_w);
        let d = self.sub_slopes(top, by_w);
        self.divide(d, w)
    }

    fn parts(&mut self, c: Dual) -> [Dual; 3] {
        [0, 1, 2].map(|i| self.component(c, i))
    }

    fn xyy_to_rgb(&mut self, c: Dual) -> Slope {
        let [x, y, light] = self.parts(c);
        let edge = self.number(1e-6).v;
        let usable = self.binary(BinaryOp::Gt, y.v, edge);
        let none = self.number(0.0);
        let scale = self.div(light, y);
        let scale = self.pick(usable, scale, none);
        let light = self.pick(usable, light, none);
        let one = self.number(1.0);
        let z = self.sub(one, x);
        let z = self.sub(z, y);
        let (x, z) = (self.mul(scale, x), self.mul(scale, z));
        let xyz = self.triple([x, light, z]);
        self.f("xyz_to_rgb", &[xyz], Ty::Triple).d
    }

    fn rgb_to_xyy(&mut self, c: Dual) -> Slope {
        let xyz = self.f("rgb_to_xyz", &[c], Ty::Triple);
        let [x, y, z] = self.parts(xyz);
        let sum = self.add(x, y);
        let sum = self.add(sum, z);
        let edge = self.number(1e-6).v;
        let usable = self.binary(BinaryOp::Ge, sum.v, edge);
        let none = self.number(0.0);
        let (a, b) = (self.div(x, sum), self.div(y, sum));
        let (a, b) = (self.pick(usable, a, none), self.pick(usable, b, none));
        self.triple([a, b, y]).d
    }

    fn hsv_to_rgb(&mut self, c: Dual) -> Dual {
        let [hue, s, v] = self.parts(c);
        let whole = self.plain("floor", &[hue.v], Ty::Float);
        let turn = self.sub(hue, Dual { v: whole, d: None });
        let h = self.linear(turn, 6.0, 0.0);
        let sector = self.plain("floor", &[h.v], Ty::Float);
        let f = self.sub(h, Dual { v: sector, d: None });
        let one = self.number(1.0);
        let mut less = |r: &mut Self, part: Dual| {
            let product = r.mul(s, part);
            let rest = r.sub(one, product);
            r.mul(v, rest)
        };
        let p = less(self, one);
        let q = less(self, f);
        let rest = self.sub(one, f);
        let t = less(self, rest);
        let mut rgb = self.triple([v, p, q]);
        for (number, parts) in [[v, t, p], [q, v, p], [p, v, t], [p, q, v], [t, p, v]].into_iter().enumerate() {
            let number = self.number(number as f64).v;
            let here = self.binary(BinaryOp::Eq, sector, number);
            let color = self.triple(parts);
            rgb = self.pick(here, color, rgb);
        }
        let edge = self.number(0.0001).v;
        let grey = self.binary(BinaryOp::Lt, s.v, edge);
        let flat = self.splat(v, Ty::Triple);
        self.pick(grey, flat, rgb)
    }

    fn hsl_to_rgb(&mut self, c: Dual) -> Dual {
        let [h, s, l] = self.parts(c);
        let half = self.number(0.5).v;
        let dark = self.binary(BinaryOp::Le, l.v, half);
        let product = self.mul(l, s);
        let below = self.add(l, product);
        let above = self.sub(l, product);
        let above = self.add(above, s);
        let v = self.pick(dark, below, above);
        let difference = self.sub(v, l);
        let difference = self.linear(difference, 2.0, 0.0);
        let saturation = self.div(difference, v);
        let hsv = self.triple([h, saturation, v]);
        let rgb = self.hsv_to_rgb(hsv);
        let zero = self.number(0.0).v;
        let black = self.binary(BinaryOp::Le, v.v, zero);
        let none = self.constant(0.0, Ty::Triple);
        self.pick(black, none, rgb)
    }

    /// The largest and the smallest of three.
    fn extremes(&mut self, [r, g, b]: [Dual; 3]) -> (Dual, Dual) {
        let ends = ["max", "min"].map(|name| {
            let two = self.f(name, &[r, g], Ty::Float);
            self.f(name, &[two, b], Ty::Float)
        });
        (ends[0], ends[1])
    }

    fn rgb_to_hsv(&mut self, c: Dual) -> Dual {
        let [r, g, b] = self.parts(c);
        let (high, low) = self.extremes([r, g, b]);
        let range = self.sub(high, low);
        // High is not positive: 0. Then so is the hue.
        let saturation = self.div(range, high);
        let zero = self.number(0.0);
        let positive = self.binary(BinaryOp::Gt, high.v, zero.v);
        let s = self.pick(positive, saturation, zero);
        let red = self.binary(BinaryOp::Ge, r.v, high.v);
        let green = self.binary(BinaryOp::Ge, g.v, high.v);
        let mut sixth = |this: &mut Self, a: Dual, b: Dual, base: f64| {
            let difference = this.sub(a, b);
            let part = this.div(difference, range);
            this.linear(part, 1.0 / 6.0, base / 6.0)
        };
        let (of_red, of_green, of_blue) = (sixth(self, g, b, 0.0), sixth(self, b, r, 2.0), sixth(self, r, g, 4.0));
        let h = self.pick(green, of_green, of_blue);
        let h = self.pick(red, of_red, h);
        let colored = self.binary(BinaryOp::Gt, s.v, zero.v);
        let h = self.pick(colored, h, zero);
        let negative = self.binary(BinaryOp::Lt, h.v, zero.v);
        let turned = self.linear(h, 1.0, 1.0);
        let h = self.pick(negative, turned, h);
        self.triple([h, s, high])
    }

    fn rgb_to_hsl(&mut self, c: Dual) -> Slope {
        let hsv = self.rgb_to_hsv(c);
        let hue = self.component(hsv, 0);
        let parts = self.parts(c);
        let (high, low) = self.extremes(parts);
        let sum = self.add(low, high);
        let l = self.linear(sum, 0.5, 0.0);
        let half = self.number(0.5).v;
        let dark = self.binary(BinaryOp::Le, l.v, half);
        let rest = self.linear(sum, -1.0, 2.0);
        let bottom = self.pick(dark, sum, rest);
        let range = self.sub(high, low);
        let s = self.div(range, bottom);
        self.triple([hue, s, l]).d
    }

    /// The derivative of sRGB's transfer curve or its inverse, by component.
    pub(super) fn slope_of_srgb(&mut self, name: &str, x: ValueId) -> ValueId {
        let ty = self.ty(x);
        let x = Dual { v: x, d: None };
        let (straight, edge, scale, curve) = if name == "srgb_to_rgb" {
            let base = self.linear(x, 1.0 / 1.055, 0.055 / 1.055);
            let exponent = self.constant(1.4, ty);
            (1.0 / 12.92, 0.04045, 2.4 / 1.055, self.plain("pow", &[base.v, exponent.v], ty))
        } else {
            let exponent = self.constant(1.0 / 2.4 - 1.0, ty);
            (12.92, 0.003_130_8, 1.055 / 2.4, self.plain("pow", &[x.v, exponent.v], ty))
        };
        let scale = self.constant(scale, ty).v;
        let curve = self.binary(BinaryOp::Mul, scale, curve);
        let (straight, edge) = (self.constant(straight, ty).v, self.constant(edge, ty).v);
        let pair = |v: ValueId| Some([v; 2]);
        self.where_ge(edge, x.v, pair(straight), pair(curve)).map_or(straight, |d| d[0])
    }
}
