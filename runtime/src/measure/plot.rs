//! Error against time as SVG, log-log, the Pareto front marked.
//!
//! In: named points with confidence intervals. Out: the text of an SVG file.

use super::Estimate;
use plotters::coord::Shift;
use plotters::prelude::*;

/// A point of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its label.
    pub name: String,
    /// Seconds.
    pub time: Estimate,
    /// The error.
    pub error: Estimate,
    /// Whether it lies on the front.
    pub on_front: bool,
}

/// Why there is no plot.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Nothing can be put on logarithmic axes.
    #[error("there is no point with a time and an error above 0")]
    Empty,
    /// The plotting library refuses.
    #[error("cannot plot: {0}")]
    Drawing(String),
}

/// Size of a plot in pixels.
const SIZE: (u32, u32) = (960, 640);

/// Draws the points.
pub fn svg(title: &str, error_name: &str, points: &[Point]) -> Result<String, Error> {
    let shown: Vec<&Point> = points.iter().filter(|p| p.time.value > 0.0 && p.error.value > 0.0).collect();
    let range = |of: &dyn Fn(&Point) -> f64| {
        let (low, high) = shown.iter().fold((f64::INFINITY, 0.0f64), |(l, h), p| (l.min(of(p)), h.max(of(p))));
        (low / 1.6)..(high * 1.6)
    };
    if shown.is_empty() {
        return Err(Error::Empty);
    }
    let (times, errors) = (range(&|p| p.time.value), range(&|p| p.error.value));
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        draw(&area, title, error_name, &shown, (times, errors)).map_err(|e| Error::Drawing(e.to_string()))?;
        area.present().map_err(|e| Error::Drawing(e.to_string()))?;
    }
    Ok(text)
}

type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

fn draw<'a>(
    area: &DrawingArea<SVGBackend<'a>, Shift>,
    title: &str,
    error_name: &str,
    points: &[&Point],
    (times, errors): (std::ops::Range<f64>, std::ops::Range<f64>),
) -> Drawn<'a> {
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 20))
        .margin(16)
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d(times.clone().log_scale(), errors.clone().log_scale())?;
    chart
        .configure_mesh()
        .x_desc("seconds")
        .y_desc(error_name)
        .x_label_formatter(&|x| short(*x))
        .y_label_formatter(&|y| short(*y))
        .max_light_lines(1)
        .bold_line_style(BLACK.mix(0.1))
        .light_line_style(TRANSPARENT)
        .draw()?;
    let mut front: Vec<(f64, f64)> =
        points.iter().filter(|p| p.on_front).map(|p| (p.time.value, p.error.value)).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, RED.stroke_width(2)))?;
    let clip = |e: &Estimate, within: &std::ops::Range<f64>| {
        let half = if e.within.is_finite() { e.within } else { 0.0 };
        ((e.value - half).max(within.start), (e.value + half).min(within.end))
    };
    let mut taken = Vec::new();
    for p in points {
        let (time, error) = (p.time.value, p.error.value);
        let (left, right) = clip(&p.time, &times);
        let (low, high) = clip(&p.error, &errors);
        let grey = BLACK.mix(0.25);
        chart.draw_series([PathElement::new([(left, error), (right, error)], grey)])?;
        chart.draw_series([PathElement::new([(time, low), (time, high)], grey)])?;
        let style = if p.on_front { RED.filled() } else { BLUE.filled() };
        let at = chart.backend_coord(&(time, error));
        let label = free_place(at, p.name.chars().count() as i32, &mut taken);
        let line = PathElement::new([(0, 0), (label.0 - 2, label.1 + 6)], BLACK.mix(0.15));
        chart.draw_series([EmptyElement::at((time, error))
            + line
            + Circle::new((0, 0), 4, style)
            + Text::new(p.name.clone(), label, ("sans-serif", FONT))])?;
    }
    Ok(())
}

/// Size of labels in pixels, and what a letter takes of them at most.
const FONT: i32 = 13;
const LETTER: i32 = 8;

/// Where a label beside a point overlaps no other: as near as can be, above or below. Offset from the point.
fn free_place(point: (i32, i32), letters: i32, taken: &mut Vec<[i32; 4]>) -> (i32, i32) {
    let width = letters * LETTER;
    let right = if point.0 + 10 + width > SIZE.0 as i32 { -10 - width } else { 10 };
    let place = |step: i32| {
        // 0, 1, -1, 2, -2 ... lines away.
        let lines = if step % 2 == 0 { -step / 2 } else { step / 2 + 1 };
        (right, lines * FONT - FONT / 2)
    };
    let shape = |(dx, dy): (i32, i32)| {
        let (x, y) = (point.0 + dx, point.1 + dy);
        [x, y, x + width, y + FONT]
    };
    let free = |b: &[i32; 4]| {
        b[1] > 0
            && b[3] < SIZE.1 as i32
            && !taken.iter().any(|t| b[0] < t[2] && t[0] < b[2] && b[1] < t[3] && t[1] < b[3])
    };
    let offset = (0..80).map(place).find(|offset| free(&shape(*offset))).unwrap_or((right, -FONT / 2));
    taken.push(shape(offset));
    offset
}

/// A number for an axis.
fn short(x: f64) -> String {
    if (0.01..10_000.0).contains(&x) { format!("{}", (x * 1000.0).round() / 1000.0) } else { format!("{x:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_their_names_are_in_the_plot() {
        let point = |name: &str, time: f64, error: f64, on_front| Point {
            name: name.to_owned(),
            time: Estimate { value: time, within: 0.1 * time },
            error: Estimate { value: error, within: f64::INFINITY },
            on_front,
        };
        let points =
            [point("draft", 0.5, 0.1, true), point("slow < bad", 40.0, 0.2, false), point("off", 1.0, 0.0, true)];
        let text = svg("r1", "relative MSE", &points).expect("a plot");
        assert!(text.starts_with("<svg") && text.contains("draft") && text.contains("slow &lt; bad"), "{text}");
        assert!(!text.contains(">off"), "an error of 0 has no place on a logarithmic axis");
        assert!(matches!(svg("none", "x", &points[2..]), Err(Error::Empty)));
    }
}
