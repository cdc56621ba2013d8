//! Points sorted into the cells of a grid, for searches on the host and on devices.
//!
//! In: positions. Out: cells; the nearest points of a place. kernels/osl/points.h searches the same way.

/// Points that a cell holds on the mean.
const PER_CELL: f64 = 4.0;

/// Most cells along an axis.
const MOST: f64 = 256.0;

/// A grid of cubes, and the points of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// The least corner.
    pub origin: [f32; 3],
    /// Cells along each axis, at least 1.
    pub cells: [u32; 3],
    /// Cells per unit of length.
    pub scale: f32,
    /// Where the points of each cell begin among `points`, and where they end; x fastest.
    pub starts: Vec<u32>,
    /// Indices of points, cell by cell, those of a cell in order.
    pub points: Vec<u32>,
}

impl Grid {
    /// Sorts points.
    pub fn new(positions: &[[f32; 3]]) -> Grid {
        let mut lo = [f32::INFINITY; 3];
        let mut hi = [f32::NEG_INFINITY; 3];
        for p in positions {
            for c in 0..3 {
                (lo[c], hi[c]) = (lo[c].min(p[c]), hi[c].max(p[c]));
            }
        }
        if positions.is_empty() {
            (lo, hi) = ([0.0; 3], [0.0; 3]);
        }
        let size = [0, 1, 2].map(|c| f64::from(hi[c]) - f64::from(lo[c]));
        let longest = size.iter().copied().fold(0.0, f64::max);
        // As many cells as wanted, of the axes along which there is anything at all.
        let wide: Vec<f64> = size.iter().copied().filter(|s| *s > 1e-3 * longest && *s > 0.0).collect();
        let wanted = (positions.len() as f64 / PER_CELL).max(1.0);
        let volume: f64 = wide.iter().product();
        let mut scale = if wide.is_empty() { 0.0 } else { (wanted / volume).powf(1.0 / wide.len() as f64) };
        if longest > 0.0 {
            scale = scale.min(MOST / longest);
        }
        let scale = if (scale as f32).is_finite() { scale as f32 } else { 0.0 };
        let cells = size.map(|s| ((s * f64::from(scale)) as u32).clamp(0, MOST as u32 - 1) + 1);
        let mut grid = Grid { origin: lo, cells, scale, starts: Vec::new(), points: Vec::new() };
        let count = cells.iter().product::<u32>() as usize;
        let of: Vec<usize> = positions.iter().map(|p| grid.cell(grid.place(p.map(f64::from)))).collect();
        let mut starts = vec![0u32; count + 1];
        of.iter().for_each(|cell| starts[cell + 1] += 1);
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut points = vec![0u32; positions.len()];
        for (i, cell) in of.iter().enumerate() {
            points[next[*cell] as usize] = i as u32;
            next[*cell] += 1;
        }
        (grid.starts, grid.points) = (starts, points);
        grid
    }

    /// The cell nearest to a place.
    fn place(&self, at: [f64; 3]) -> [u32; 3] {
        [0, 1, 2].map(|c| {
            let x = (at[c] - f64::from(self.origin[c])) * f64::from(self.scale);
            (x.clamp(0.0, f64::from(self.cells[c] - 1))) as u32
        })
    }

    fn cell(&self, [x, y, z]: [u32; 3]) -> usize {
        ((z * self.cells[1] + y) * self.cells[0] + x) as usize
    }

    /// The points within a radius, at most so many, the closest ones: index and distance, by distance, then by index.
    pub fn nearest(&self, positions: &[[f32; 3]], center: [f64; 3], radius: f64, most: usize) -> Vec<(i32, f64)> {
        let mut found: Vec<(f64, u32)> = Vec::new();
        if radius.is_nan() || radius < 0.0 || most == 0 || self.starts.is_empty() {
            return Vec::new();
        }
        // A cell more on each side: rounding may put a point over the edge of its own.
        let slack = if self.scale > 0.0 { radius + 1e-3 / f64::from(self.scale) } else { radius };
        let [lo, hi] = [-slack, slack].map(|r| self.place(center.map(|x| x + r)));
        for z in lo[2]..=hi[2] {
            for y in lo[1]..=hi[1] {
                let row = self.starts[self.cell([lo[0], y, z])]..self.starts[self.cell([hi[0], y, z]) + 1];
                for &i in &self.points[row.start as usize..row.end as usize] {
                    let p = positions[i as usize];
                    let d: f64 = (0..3).map(|c| (center[c] - f64::from(p[c])).powi(2)).sum();
                    if d <= radius * radius {
                        found.push((d, i));
                    }
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(most);
        found.into_iter().map(|(d, i)| (i as i32, d.sqrt())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Grid;

    /// Numbers that look random.
    fn scattered(count: u32, flat: bool) -> Vec<[f32; 3]> {
        let number = |i: u32, k: u32| ((i * 7919 + k * 104_729) % 10_007) as f32 / 10_007.0 - 0.5;
        (0..count).map(|i| [3.0 * number(i, 1), number(i, 2), if flat { 1.0 } else { number(i, 3) }]).collect()
    }

    #[test]
    fn searches_find_what_looking_at_all_points_finds() {
        for (count, flat) in [(1, true), (2, false), (500, true), (2000, false)] {
            let points = scattered(count, flat);
            let grid = Grid::new(&points);
            assert!(grid.starts.len() < 2 * points.len() + 300, "{} cells", grid.starts.len());
            for (k, radius) in [0.0, 0.05, 0.3, 10.0, 1e30].into_iter().enumerate() {
                let center = points[(k * 37) % points.len()].map(f64::from);
                let mut all: Vec<(f64, i32)> = Vec::new();
                for (i, p) in points.iter().enumerate() {
                    let d: f64 = (0..3).map(|c| (center[c] - f64::from(p[c])).powi(2)).sum();
                    all.push((d, i as i32));
                }
                all.retain(|(d, _)| *d <= radius * radius);
                all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                for most in [0, 1, 7, 5000] {
                    let found = grid.nearest(&points, center, radius, most);
                    let wanted: Vec<(i32, f64)> = all.iter().take(most).map(|(d, i)| (*i, d.sqrt())).collect();
                    assert_eq!(found, wanted, "{count} points, radius {radius}, most {most}");
                }
            }
        }
    }

    #[test]
    fn what_has_no_extent_has_one_cell() {
        assert_eq!(Grid::new(&[]).nearest(&[], [0.0; 3], 1.0, 5), []);
        let same = vec![[2.0; 3]; 100];
        assert_eq!(Grid::new(&same).nearest(&same, [2.0; 3], 0.0, 2), [(0, 0.0), (1, 0.0)]);
        assert_eq!(Grid::new(&same).nearest(&same, [2.0; 3], f64::NAN, 2), []);
    }
}
