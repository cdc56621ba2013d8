//! Runs the lobes of kernels/bsdf on the device, outside any scene.
//!
//! In: a [`Case`]: a closure, its arguments, a direction to the viewer. Out: samples and integrals. What they have to fulfil
//! stands in tests/tests/bsdf.rs.

pub mod cases;
pub mod statistics;

use oslcl_runtime::assemble::assemble;
use oslcl_runtime::device::{Arg, Buffer, Device, Error, Program};
use oslcl_runtime::precision::Precision;

/// Rings of a polar grid.
pub const RINGS: usize = 20;
/// Sectors of a polar grid.
pub const SECTORS: usize = 24;
/// Bins of the two grids.
pub const BINS: usize = 2 * RINGS * SECTORS;
/// Reals of a case, as lobes.cl reads them.
const CASE_REALS: usize = 38;

/// Work-items of a group.
const GROUP: usize = 32;

/// A vector in world space.
pub type Vec3 = [f64; 3];

/// The closures that are lobes, numbered as lobes.cl does; the name is that of the constructor.
pub const CLOSURES: [&str; 22] = [
    "diffuse(normal)",
    "oren_nayar(normal,float)",
    "translucent(normal)",
    "phong(normal,float)",
    "ward(normal,vector,float,float)",
    "microfacet(string,normal,vector,float,float,float,int)",
    "microfacet(string,normal,float,float,int)",
    "reflection(normal,float)",
    "reflection(normal)",
    "refraction(normal,float)",
    "conductor_bsdf(normal,vector,float,float,color,color,string)",
    "transparent()",
    "subsurface(float,float,color,color)",
    "oren_nayar_diffuse_bsdf(normal,color,float)",
    "burley_diffuse_bsdf(normal,color,float)",
    "dielectric_bsdf(normal,vector,color,color,float,float,float,string)",
    "generalized_schlick_bsdf(normal,vector,color,color,float,float,color,color,float,string)",
    "translucent_bsdf(normal,color)",
    "subsurface_bssrdf(normal,color,color,float)",
    "sheen_bsdf(normal,color,float)",
    "chiang_hair_bsdf(normal,vector,color,color,color,float,float,float,float,float,float,float,float,color)",
    "transparent_bsdf()",
];

/// A lobe and a direction to the viewer.
#[derive(Clone, Debug)]
pub struct Case {
    /// Index into [`CLOSURES`].
    pub closure: usize,
    /// 0 "ggx", 1 "beckmann", 2 "default", 3 an unknown name; plus 4: under a thin film.
    pub dist: i32,
    /// Of microfacet and the dielectrics: 0 reflects, 1 refracts, 2 both. Else a closure's option: energy_compensation, mode, tilt.
    pub refract: i32,
    /// Roughness, exponent or sigma.
    pub a: f64,
    /// Roughness across.
    pub b: f64,
    /// Index of refraction.
    pub eta: f64,
    /// Of a conductor.
    pub ior: Vec3,
    /// Of a conductor.
    pub extinction: Vec3,
    /// Unit normal.
    pub n: Vec3,
    /// Angle between normal and viewer in degrees.
    pub degrees: f64,
}

/// a . b
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a + b s
pub fn add(a: Vec3, b: Vec3, s: f64) -> Vec3 {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

/// v / |v|
pub fn normalize(v: Vec3) -> Vec3 {
    let len = dot(v, v).sqrt();
    v.map(|x| x / len)
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Two directions across.
fn across(n: Vec3) -> (Vec3, Vec3) {
    let other = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let s = normalize(cross(n, other));
    (s, cross(n, s))
}

/// Rings around an axis: half of them within 1 - cos < `scale`.
#[derive(Clone, Copy, Debug)]
pub struct Polar {
    axis: Vec3,
    s: Vec3,
    t: Vec3,
    scale: f64,
}

impl Polar {
    fn new(axis: Vec3, scale: f64) -> Polar {
        let (s, t) = across(axis);
        Polar { axis, s, t, scale }
    }

    /// Ring and sector of a direction, as one index.
    fn bin(&self, wi: Vec3) -> usize {
        let chord = add(wi, self.axis, -1.0);
        // By the chord: 1 - cos cancels near the axis.
        let d = (0.5 * dot(chord, chord)).min(2.0);
        let q = d / (d + self.scale) * (2.0 + self.scale) / 2.0;
        let phi = dot(wi, self.t).atan2(dot(wi, self.s)).rem_euclid(std::f64::consts::TAU);
        let ring = ((q * RINGS as f64) as usize).min(RINGS - 1);
        let sector = ((phi / std::f64::consts::TAU * SECTORS as f64) as usize).min(SECTORS - 1);
        ring * SECTORS + sector
    }
}

impl Case {
    /// Direction to the viewer.
    pub fn wo(&self) -> Vec3 {
        let (s, t) = across(self.n);
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        let side = add(s.map(|x| x * 0.8), t, 0.6);
        add(self.n.map(|x| x * cos), side, sin)
    }

    /// The mirror direction.
    pub fn mirror(&self) -> Vec3 {
        let wo = self.wo();
        add(wo.map(|x| -x), self.n, 2.0 * dot(wo, self.n))
    }

    /// The refracted direction and the cosine below; along the surface at total reflection.
    pub fn refracted(&self, eta: f64) -> (Vec3, f64) {
        let wo = self.wo();
        let c = dot(wo, self.n);
        let tangential = add(wo, self.n, -c).map(|x| -x / eta);
        // As 1 - sin^2 it would have no digits at grazing incidence.
        let cos2 = (eta - 1.0) * (eta + 1.0) / (eta * eta) + (c / eta) * (c / eta);
        if cos2 <= 0.0 {
            return (normalize(tangential), 0.0);
        }
        (add(tangential, self.n, -cos2.sqrt()), cos2.sqrt())
    }

    /// One grid above the surface, one below, fitted to the lobe's peaks.
    pub fn grids(&self) -> [Polar; 2] {
        let below = self.n.map(|x| -x);
        match self.closure {
            3 => [Polar::new(self.mirror(), 1.0 / (self.a + 1.0)), Polar::new(below, 8.0)],
            4..=6 | 10 | 15 | 16 => {
                let alpha = if self.closure == 6 { self.a } else { (self.a * self.b).sqrt() }.max(1e-4);
                let eta = if (self.eta - 1.0).abs() < 1e-3 { 1.001 } else { self.eta };
                let (axis, cos_t) = if eta > 0.0 { self.refracted(eta) } else { (below, 1.0) };
                let cos = dot(self.n, self.wo());
                let spread = if cos_t > 0.0 {
                    (1.0 - cos / (eta * cos_t)).abs().max(0.3 * (1.0 - 1.0 / eta).abs())
                } else {
                    1.0
                };
                let width = alpha * spread;
                [Polar::new(self.mirror(), 2.0 * alpha * alpha), Polar::new(axis, (0.5 * width * width).min(8.0))]
            }
            _ => [Polar::new(self.n, 8.0), Polar::new(below, 8.0)],
        }
    }

    /// The bin of a direction: the first grid's above the surface, the second's below.
    pub fn bin(&self, grids: &[Polar; 2], wi: Vec3) -> usize {
        if dot(self.n, wi) > 0.0 { grids[0].bin(wi) } else { RINGS * SECTORS + grids[1].bin(wi) }
    }

    fn ints(&self) -> [Arg<'static>; 3] {
        [self.closure as i32, self.dist, self.refract].map(Arg::I32)
    }

    fn reals(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(CASE_REALS);
        out.extend(self.n);
        // A tangent that is neither unit nor perpendicular.
        let (s, t) = across(self.n);
        out.extend(add(add(s.map(|x| x * 2.0), t, 0.7), self.n, 0.3));
        out.extend(self.wo());
        out.extend([self.a, self.b, self.eta]);
        out.extend(self.ior);
        out.extend(self.extinction);
        for g in self.grids() {
            out.extend(g.axis);
            out.extend(g.s);
            out.extend(g.t);
            out.push(g.scale);
        }
        out
    }
}

/// What bsdf_sample returned, and bsdf_eval for the same direction.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// SAMPLE_* bits; 0: no direction.
    pub flags: i32,
    /// The direction.
    pub wi: Vec3,
    /// f |cos| / pdf
    pub value: Vec3,
    /// Density by bsdf_sample.
    pub pdf: f64,
    /// f |cos| by bsdf_eval.
    pub f: Vec3,
    /// Density by bsdf_eval.
    pub eval_pdf: f64,
    /// f |cos| with the directions swapped.
    pub swapped: Vec3,
    /// bsdf_albedo.
    pub albedo: f64,
    /// NAME_albedo3.
    pub albedo3: Vec3,
}

/// The built kernels in one precision.
pub struct Lab {
    device: Device,
    precision: Precision,
    program: Program,
}

impl Lab {
    /// Builds them for the first device.
    pub fn new(precision: Precision) -> Result<Lab, Box<dyn std::error::Error>> {
        Lab::on(Device::open(None)?, precision)
    }

    /// Builds them for a device.
    pub fn on(device: Device, precision: Precision) -> Result<Lab, Box<dyn std::error::Error>> {
        let text = assemble("lobes.cl", include_str!("lobes.cl"))?;
        let program = Program::build(&device, "lobes.cl", &text, &device.options(precision.build_options()))?;
        Ok(Lab { device, precision, program })
    }

    /// Rounding error of the working precision.
    pub fn epsilon(&self) -> f64 {
        if self.precision.is_double() { f64::EPSILON } else { f64::from(f32::EPSILON) }
    }

    fn upload(&self, label: &str, data: &[f64]) -> Result<Buffer, Error> {
        if self.precision.is_double() {
            return self.device.upload(label, data);
        }
        let data: Vec<f32> = data.iter().map(|v| *v as f32).collect();
        self.device.upload(label, &data)
    }

    fn reals(&self, label: &str, count: usize) -> Result<Buffer, Error> {
        self.device.buffer(label, count as u64 * self.precision.real_bytes())
    }

    fn read(&self, buffer: &Buffer, count: usize) -> Result<Vec<f64>, Error> {
        if self.precision.is_double() {
            return self.device.read(buffer, count);
        }
        Ok(self.device.read::<f32>(buffer, count)?.into_iter().map(f64::from).collect())
    }

    fn launch(&self, kernel: &str, args: &[Arg], items: usize) -> Result<(), Error> {
        self.program.kernel(&self.device, kernel)?.launch(&self.device, args, items, GROUP)
    }

    /// Samples a case; `count` is a multiple of 32.
    pub fn sample(&self, case: &Case, count: usize, seed: u32) -> Result<Vec<Sample>, Error> {
        let p = self.upload("case", &case.reals())?;
        let out = self.reals("samples", 19 * count)?;
        let [which, dist, refract] = case.ints();
        self.launch("sample_lobe", &[which, dist, refract, Arg::Buffer(&p), Arg::U32(seed), Arg::Buffer(&out)], count)?;
        let triple = |v: &[f64], at: usize| [v[at], v[at + 1], v[at + 2]];
        let sample = |v: &[f64]| Sample {
            flags: v[0] as i32,
            wi: triple(v, 1),
            value: triple(v, 4),
            pdf: v[7],
            f: triple(v, 8),
            eval_pdf: v[11],
            swapped: triple(v, 12),
            albedo: v[15],
            albedo3: triple(v, 16),
        };
        Ok(self.read(&out, 19 * count)?.chunks_exact(19).map(sample).collect())
    }

    /// The integrals of density and of f |cos| (first channel) over each bin, by `steps` x `steps` points.
    pub fn integrate(&self, case: &Case, steps: i32) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let p = self.upload("case", &case.reals())?;
        let out = self.reals("integrals", 2 * BINS)?;
        let [which, dist, refract] = case.ints();
        let [rings, sectors, steps] = [RINGS as i32, SECTORS as i32, steps].map(Arg::I32);
        let args = [which, dist, refract, Arg::Buffer(&p), rings, sectors, steps, Arg::Buffer(&out)];
        self.launch("integrate_lobe", &args, BINS)?;
        Ok(self.read(&out, 2 * BINS)?.chunks_exact(2).map(|v| (v[0], v[1])).unzip())
    }

    /// Picks among lobes `count` times, a multiple of 32, with evenly spread numbers: type and weight of each pick.
    pub fn pick(&self, case: &Case, offers: &[(usize, Vec3)], count: usize) -> Result<Vec<(i32, Vec3)>, Error> {
        let which: Vec<i32> = offers.iter().map(|o| o.0 as i32).collect();
        let which = self.device.upload("closures", &which)?;
        let weights: Vec<f64> = offers.iter().flat_map(|o| o.1).collect();
        let weights = self.upload("weights", &weights)?;
        let p = self.upload("case", &case.reals())?;
        let out = self.reals("picks", 4 * count)?;
        let number = Arg::I32(offers.len() as i32);
        let (which, weights) = (Arg::Buffer(&which), Arg::Buffer(&weights));
        let args = [number, which, weights, Arg::Buffer(&p), Arg::I32(count as i32), Arg::Buffer(&out)];
        self.launch("pick_lobe", &args, count)?;
        Ok(self.read(&out, 4 * count)?.chunks_exact(4).map(|v| (v[0] as i32, [v[1], v[2], v[3]])).collect())
    }

    /// Asks for lobes with random parameters, `count` a multiple of 32. For each: what was wrong (0 nothing, 1 sample,
    /// 2 eval, 3 albedo), and closure + 32 distribution + 256 (refract + 1).
    pub fn wild(&self, count: usize, seed: u32) -> Result<Vec<(i32, i32)>, Error> {
        let p = self.reals("cases", CASE_REALS * count)?;
        let out = self.device.buffer("results", (count * 8) as u64)?;
        self.launch("wild_lobe", &[Arg::U32(seed), Arg::Buffer(&p), Arg::Buffer(&out)], count)?;
        Ok(self.device.read::<i32>(&out, 2 * count)?.chunks_exact(2).map(|v| (v[0], v[1])).collect())
    }
}
