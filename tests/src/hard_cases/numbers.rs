//! Sums and random numbers on the device, without scenes: kernels/compensated.h, kernels/context.h and kernels/random.h.
//!
//! In: how many. Out: errors and ranges.

use super::Run;
use oslcl_runtime::assemble::assemble_with;
use oslcl_runtime::device::{Arg, Error, Program};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::render;

/// The kernels.
pub struct Numbers<'a> {
    run: &'a Run<'a>,
    program: Program,
}

/// Relative errors of a sum of many samples.
#[derive(Clone, Copy, Debug)]
pub struct SumErrors {
    /// Of the film's sums.
    pub compensated: f64,
    /// Of the same sum without compensation.
    pub plain: f64,
}

/// What random numbers are like.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Numbers outside [0, 1).
    pub outside: u32,
    /// The least.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// Their mean.
    pub mean: f64,
}

impl<'a> Numbers<'a> {
    /// Builds the kernels.
    pub fn new(run: &'a Run<'a>) -> Result<Numbers<'a>, Box<dyn std::error::Error>> {
        let mut scene = crate::scenes::empty();
        super::pictures::sky(&mut scene, 1.0);
        let (plan, _) = render::plan(&scene, &run.precision.into())?;
        let text = assemble_with("numbers.cl", include_str!("numbers.cl"), &[("layout.h", &plan.layout.header())])?;
        let program = Program::build(run.device, "numbers.cl", &text, run.precision.build_options())?;
        Ok(Numbers { run, program })
    }

    fn launch(&self, kernel: &str, args: &[Arg<'_>], items: usize, group: usize) -> Result<(), Error> {
        self.program.kernel(self.run.device, kernel)?.launch(self.run.device, args, items, group)
    }

    /// Sums `count` samples of one pixel as the film does, in eight pixels; the largest errors against exact sums.
    pub fn sums(&self, count: u32, seed: u32) -> Result<SumErrors, Error> {
        const ITEMS: usize = 8;
        let device = self.run.device;
        let out = self.run.upload("sums", &[0.0; 3 * ITEMS])?;
        let exact = device.upload("exact", &[0u32; 2 * ITEMS])?;
        let args = [Arg::U32(count), Arg::U32(seed), Arg::Buffer(&out), Arg::Buffer(&exact)];
        self.launch("add_samples", &args, ITEMS, ITEMS)?;
        let sums = self.run.read(&out, 3 * ITEMS)?;
        let exact: Vec<u32> = device.read(&exact, 2 * ITEMS)?;
        let mut errors = SumErrors { compensated: 0.0, plain: 0.0 };
        for (sum, words) in sums.chunks(3).zip(exact.chunks(2)) {
            let wanted = (f64::from(words[1]) * 4294967296.0 + f64::from(words[0])) / 4096.0;
            // As `resolve` reads it: the sum less what it lost.
            let narrow = |x: f64| if self.run.precision == Precision::Reference { x } else { f64::from(x as f32) };
            errors.compensated = errors.compensated.max((narrow(sum[0] - sum[1]) / wanted - 1.0).abs());
            errors.plain = errors.plain.max((sum[2] / wanted - 1.0).abs());
        }
        Ok(errors)
    }

    /// What a 64-bit counter of the device says after `times` steps of n from `start`.
    pub fn count(&self, start: u64, n: u32, times: u32) -> Result<u64, Error> {
        let words = self.run.device.upload("words", &[start as u32, (start >> 32) as u32])?;
        self.launch("count_far", &[Arg::U32(n), Arg::U32(times), Arg::Buffer(&words)], 1, 1)?;
        let words: Vec<u32> = self.run.device.read(&words, 2)?;
        Ok(u64::from(words[0]) | u64::from(words[1]) << 32)
    }

    /// Four random numbers for each of `items` x `turns` counters from `first` on, in turn as pixel, sample, dimension and seed.
    pub fn random(&self, first: u32, items: usize, turns: u32, seed: u32) -> Result<Range, Error> {
        let device = self.run.device;
        let outside = device.upload("outside", &[0u32])?;
        let found = self.run.upload("found", &vec![0.0; 3 * items])?;
        let args = [Arg::U32(first), Arg::U32(turns), Arg::U32(seed), Arg::Buffer(&outside), Arg::Buffer(&found)];
        self.launch("random_range", &args, items, 64)?;
        let found = self.run.read(&found, 3 * items)?;
        let mut range = Range { outside: device.read::<u32>(&outside, 1)?[0], least: 2.0, most: -1.0, mean: 0.0 };
        for item in found.chunks(3) {
            range.least = range.least.min(item[0]);
            range.most = range.most.max(item[1]);
            range.mean += item[2] / items as f64;
        }
        Ok(range)
    }

    /// Of all 2^24 values that the kept bits of a random word have: how many become numbers outside [0, 1), and how many are not
    /// exactly these bits.
    pub fn edges(&self) -> Result<[u32; 2], Error> {
        let out = self.run.device.upload("wrong", &[0u32; 2])?;
        self.launch("random_edges", &[Arg::Buffer(&out)], 1 << 24, 64)?;
        let wrong: Vec<u32> = self.run.device.read(&out, 2)?;
        Ok([wrong[0], wrong[1]])
    }
}

/// What a kernel of sobol.cl writes: `count` times four words.
fn points(run: &Run<'_>, kernel: &str, count: usize) -> Result<Vec<u32>, Box<dyn std::error::Error>> {
    let text = assemble_with("sobol.cl", include_str!("sobol.cl"), &[])?;
    let program = Program::build(run.device, "sobol.cl", &text, run.precision.build_options())?;
    let out = run.device.upload("points", &vec![0u32; 4 * count])?;
    program.kernel(run.device, kernel)?.launch(run.device, &[Arg::Buffer(&out)], count, 64)?;
    Ok(run.device.read(&out, 4 * count)?)
}

/// How far from half the share of ones is, at most, of any of the 32 bits of the words that `count` cubes have, and of their singles.
pub fn uneven_cube_bits(run: &Run<'_>, count: usize) -> Result<f64, Box<dyn std::error::Error>> {
    let words = points(run, "cube_words", count)?;
    let share = |word: usize, bit: u32| {
        let ones = words.chunks(4).filter(|w| w[word] >> bit & 1 == 1).count();
        ones as f64 / count as f64
    };
    let bits = (0..4).flat_map(|word| (0..32).map(move |bit| (word, bit)));
    Ok(bits.map(|(word, bit)| (share(word, bit) - 0.5).abs()).fold(0.0, f64::max))
}

/// How many of `count` points of Sobol's sequence differ from the sums of its direction numbers.
pub fn wrong_sobol_points(run: &Run<'_>, count: usize) -> Result<usize, Box<dyn std::error::Error>> {
    let points = points(run, "sobol_points", count)?;
    // Degree, inner coefficients and first numbers of the primitive polynomials: Joe and Kuo, new-joe-kuo-6.21201, d = 2 to 4.
    let columns = [
        std::array::from_fn(|bit| 0x8000_0000 >> bit),
        direction_numbers(1, 0, &[1]),
        direction_numbers(2, 1, &[1, 3]),
        direction_numbers(3, 1, &[1, 3, 1]),
    ];
    let sum = |index: u32, columns: &[u32; 32]| {
        columns.iter().enumerate().filter(|(bit, _)| index >> bit & 1 == 1).fold(0, |sum, (_, c)| sum ^ c)
    };
    let is_wrong = |(i, point): &(usize, &[u32])| {
        let index = (*i as u32).wrapping_mul(0x9e37_79b9);
        (0..4).any(|d| point[d].reverse_bits() != sum(index, &columns[d]))
    };
    Ok(points.chunks(4).enumerate().filter(is_wrong).count())
}

/// The direction numbers of one dimension, by their recurrence: Bratley and Fox, ACM TOMS 14(1), 1988, eq. 2.
fn direction_numbers(degree: usize, inner: u32, first: &[u32]) -> [u32; 32] {
    let mut columns = [0u32; 32];
    for bit in 0..32 {
        columns[bit] = match first.get(bit) {
            Some(number) => number << (31 - bit),
            None => (1..degree)
                .filter(|k| inner >> (degree - 1 - k) & 1 == 1)
                .fold(columns[bit - degree] ^ columns[bit - degree] >> degree, |sum, k| sum ^ columns[bit - k]),
        };
    }
    columns
}
