//! Which pixels have had enough samples: those of tiles whose error is small (`--set adaptive=...`).
//!
//! In: the film's sums at some numbers of samples. Out: the pixels that go on, the samples that each has had, the picture. It must not
//! know devices.
//!
//! The idea is that of Dammertz, Hanika, Keller, Lensch: "A Hierarchical Automatic Stopping Condition for Monte Carlo Global
//! Illumination", WSCG 2010: the samples so far are taken in two parts, and how far the parts are apart tells the error of all, tile by
//! tile. Theirs are two films of every other sample; here they are what the film held at the last look and what came since, so that
//! there is one film, and both parts of a sampler's points are even in themselves. The error is that of `--target-error`: with
//! means a of n samples and b of m, the mean x of all has the squared error (a - b)^2 n m / (n + m)^2, seen in relation to
//! x^2 + 0.01. Samples that are more even than independent ones make it larger than it is, never smaller.

/// Pixels of a tile each way. The noise of a tile's estimate falls with their number.
pub const TILE: usize = 8;

/// Samples per pixel before the first look: fewer may all miss what is seldom and bright.
pub const LEAST: u32 = 16;

/// A tile also goes on while one beside it has an error this many times the threshold: what one has seen of a light
/// that is seldom found, the other may have missed.
const BESIDE: f64 = 3.0;

/// Added to squared radiance, so that what is black may have an error as well.
const DARK: f64 = 0.01;

/// A render whose pixels may end early.
#[derive(Clone, Debug)]
pub struct Adaptive {
    threshold: f64,
    width: usize,
    height: usize,
    channels: usize,
    /// Samples of every pixel that goes on.
    done: u32,
    /// Samples at the last look, and the film's sums then.
    before: u32,
    sums: Vec<f64>,
    tiles: Vec<Tile>,
}

#[derive(Clone, Copy, Debug)]
struct Tile {
    /// Squared.
    error: f64,
    /// Samples of its pixels; `None`: it goes on.
    ended: Option<u32>,
}

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The relative error that was asked for.
    pub threshold: f64,
    /// Tiles, and how many of them reached it.
    pub tiles: (u32, u32),
    /// Samples per pixel: fewest, most, and the mean.
    pub samples: (u32, u32, f64),
    /// Part of the samples that were asked for and not taken.
    pub saved: f64,
}

impl Adaptive {
    /// Before the first sample of a picture with this many channels, the first three of which are colours.
    pub fn new(threshold: f64, width: usize, height: usize, channels: usize) -> Adaptive {
        let tiles = width.div_ceil(TILE) * height.div_ceil(TILE);
        let tile = Tile { error: f64::INFINITY, ended: None };
        let sums = vec![0.0; width * height * channels];
        Adaptive { threshold, width, height, channels, done: 0, before: 0, sums, tiles: vec![tile; tiles] }
    }

    /// Samples per pixel at the next look: powers of two, at which samplers are even, and halfway between.
    pub fn next_look(&self) -> u32 {
        if self.done < LEAST {
            return LEAST;
        }
        let power = 1 << self.done.ilog2();
        let half = power + power / 2;
        if self.done < half { half } else { power.saturating_mul(2) }
    }

    fn across(&self) -> usize {
        self.width.div_ceil(TILE)
    }

    fn tile_of(&self, pixel: usize) -> usize {
        pixel / self.width / TILE * self.across() + pixel % self.width / TILE
    }

    /// Looks at the film's sums, channels interleaved, after `done` samples of each pixel that goes on. A first look says nothing yet: there
    /// is nothing to compare.
    pub fn look(&mut self, done: u32, sums: &[f64]) {
        self.done = done;
        if self.before > 0 && done > self.before {
            self.estimate(done, sums);
            self.end_tiles(done);
        }
        self.before = done;
        self.sums.copy_from_slice(sums);
    }

    fn estimate(&mut self, done: u32, sums: &[f64]) {
        let (n, m) = (f64::from(self.before), f64::from(done - self.before));
        let share = n * m / ((n + m) * (n + m));
        let mut errors = vec![(0.0, 0u32); self.tiles.len()];
        let pixels = sums.chunks(self.channels).zip(self.sums.chunks(self.channels));
        for (pixel, (now, before)) in pixels.enumerate() {
            let (error, count) = &mut errors[self.tile_of(pixel)];
            for (now, before) in now.iter().zip(before).take(3) {
                let (a, b, x) = (before / n, (now - before) / m, now / (n + m));
                *error += share * (a - b) * (a - b) / (x * x + DARK);
                *count += 1;
            }
        }
        for (tile, (error, count)) in self.tiles.iter_mut().zip(errors) {
            if tile.ended.is_none() {
                tile.error = error / f64::from(count.max(1));
            }
        }
    }

    fn end_tiles(&mut self, done: u32) {
        let wanted = self.threshold * self.threshold;
        let (across, down) = (self.across(), self.height.div_ceil(TILE));
        let errors: Vec<f64> = self.tiles.iter().map(|t| t.error).collect();
        for (i, tile) in self.tiles.iter_mut().enumerate() {
            let (x, y) = (i % across, i / across);
            let rows = y.saturating_sub(1)..(y + 2).min(down);
            let columns = x.saturating_sub(1)..(x + 2).min(across);
            let mut beside = rows.flat_map(|y| columns.clone().map(move |x| y * across + x));
            let calm = beside.all(|k| errors[k] <= BESIDE * BESIDE * wanted);
            if tile.ended.is_none() && tile.error <= wanted && calm {
                tile.ended = Some(done);
            }
        }
    }

    /// The pixels that go on, in order.
    pub fn going_on(&self) -> Vec<u32> {
        let all = 0..self.width * self.height;
        all.filter(|p| self.tiles[self.tile_of(*p)].ended.is_none()).map(|p| p as u32).collect()
    }

    /// Samples of a pixel, if those that go on have `done`.
    fn samples_of(&self, pixel: usize, done: u32) -> u32 {
        self.tiles[self.tile_of(pixel)].ended.unwrap_or(done)
    }

    /// The film's sums after `done` samples of each pixel that went on as means, and what came of it where `wanted` were allowed.
    pub fn finish(mut self, done: u32, wanted: u32, sums: &[f64]) -> (Vec<f64>, Outcome) {
        if self.before > 0 && done > self.before {
            self.estimate(done, sums);
        }
        let counts: Vec<u32> = (0..self.width * self.height).map(|p| self.samples_of(p, done)).collect();
        let means = sums.chunks(self.channels).zip(&counts);
        let means = means.flat_map(|(p, n)| p.iter().map(|x| x / f64::from(*n))).collect();
        let pixels = counts.len().max(1) as f64;
        let taken: f64 = counts.iter().map(|n| f64::from(*n)).sum();
        let reached = self.tiles.iter().filter(|t| t.error <= self.threshold * self.threshold).count();
        let least = counts.iter().copied().min().unwrap_or(done);
        let most = counts.iter().copied().max().unwrap_or(done);
        let outcome = Outcome {
            threshold: self.threshold,
            tiles: (self.tiles.len() as u32, reached as u32),
            samples: (least, most, taken / pixels),
            saved: 1.0 - taken / (pixels * f64::from(wanted.max(1))),
        };
        (means, outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums after `n` samples of two tiles beside each other: the left one is 1, the right one off by `off`.
    fn sums(n: f64, off: f64) -> Vec<f64> {
        let pixel = |i: usize| if i % (2 * TILE) < TILE { n } else { n * (1.0 + off) };
        (0..2 * TILE * TILE).flat_map(|i| [pixel(i); 3]).collect()
    }

    #[test]
    fn looks_are_at_powers_of_two_and_between() {
        let mut adaptive = Adaptive::new(0.1, 8, 8, 3);
        let mut looks = Vec::new();
        for _ in 0..7 {
            adaptive.done = adaptive.next_look();
            looks.push(adaptive.done);
        }
        assert_eq!(looks, [16, 24, 32, 48, 64, 96, 128]);
        adaptive.done = 50;
        assert_eq!(adaptive.next_look(), 64);
    }

    #[test]
    fn a_tile_ends_when_its_parts_agree() {
        let mut adaptive = Adaptive::new(0.01, 2 * TILE, TILE, 3);
        adaptive.look(16, &sums(16.0, 0.0));
        assert_eq!(adaptive.going_on().len(), 2 * TILE * TILE, "one part says nothing");
        // The right one's parts are 1 and 1.06: 0.06 / 2 over 1.03 is an error of 0.029, less than three times as large.
        adaptive.look(32, &sums(32.0, 0.03));
        let going: Vec<u32> = adaptive.going_on();
        assert_eq!(going.len(), TILE * TILE);
        assert!(going.iter().all(|p| *p as usize % (2 * TILE) >= TILE), "{going:?}");
        let error = adaptive.tiles[1].error;
        assert!((error.sqrt() - 0.03 / (1.03f64 * 1.03 + DARK).sqrt()).abs() < 1e-9, "{error}");
        // Then both parts are 1.03.
        adaptive.look(64, &sums(64.0, 0.03));
        assert!(adaptive.going_on().is_empty());
        let mut last = sums(64.0, 0.03);
        (0..2 * TILE * TILE).filter(|i| i % (2 * TILE) < TILE).for_each(|i| last[3 * i..3 * i + 3].fill(32.0));
        let (means, outcome) = adaptive.finish(64, 128, &last);
        assert!(means.iter().enumerate().all(|(i, x)| {
            let wanted = if i / 3 % (2 * TILE) < TILE { 1.0 } else { 1.03 };
            (x - wanted).abs() < 1e-12
        }));
        assert_eq!((outcome.tiles, outcome.samples), ((2, 2), (32, 64, 48.0)));
        assert!((outcome.saved - (1.0 - 48.0 / 128.0)).abs() < 1e-12);
    }

    #[test]
    fn a_tile_beside_a_wild_one_goes_on() {
        let mut adaptive = Adaptive::new(0.01, 2 * TILE, TILE, 3);
        adaptive.look(16, &sums(16.0, 0.0));
        adaptive.look(32, &sums(32.0, 0.2));
        assert_eq!(adaptive.going_on().len(), 2 * TILE * TILE);
    }

    #[test]
    fn tiles_at_the_edge_are_smaller() {
        let adaptive = Adaptive::new(0.1, TILE + 3, 2 * TILE + 1, 4);
        assert_eq!(adaptive.tiles.len(), 6);
        assert_eq!(adaptive.going_on().len(), (TILE + 3) * (2 * TILE + 1));
        assert_eq!(adaptive.tile_of((TILE + 3) * (2 * TILE + 1) - 1), 5);
    }
}
