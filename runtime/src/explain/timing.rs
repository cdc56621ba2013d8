//! What effects cost in time: the scene as planned against the same without each effect that is on, or with one that is off.
//!
//! In: a scene, a device. Out: [`Timing`]s. It must not know how anything is printed.

use crate::choices::Choices;
use crate::device::Device;
use crate::film::Picture;
use crate::plan::{Decision, Effect};
use crate::render::{Error, Options};
use crate::scene::Scene;
use crate::session::Session;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Timed renders of each kind, in turn; one more before them warms up.
    pub runs: u32,
    /// Whether effects that are off are measured too, by forcing them on.
    pub forced: bool,
}

/// How the other renderer differs from the planned one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The effect is left out.
    Without,
    /// The effect is forced on.
    Forced,
}

/// What an effect costs.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Which.
    pub effect: Effect,
    /// What the planned renderer is compared with.
    pub change: Change,
    /// Other effects that are changed with it, because they need it or it needs them.
    pub also: Vec<Effect>,
    /// The cost; why there is none: such a scene can't be rendered.
    pub cost: Result<Cost, String>,
}

/// Times and pictures of two renderers.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Seconds of each sample of all pixels, as planned, by run.
    pub planned: Vec<f64>,
    /// The same of the other renderer.
    pub other: Vec<f64>,
    /// How far the pictures differ: the sum of all differences over the sum of all values of the planned one.
    pub difference: f64,
}

impl Cost {
    /// Seconds of a sample that the effect takes: the median of the runs' differences, the least and the greatest.
    pub fn seconds(&self, change: Change) -> (f64, f64, f64) {
        let sign = if change == Change::Without { 1.0 } else { -1.0 };
        let mut all: Vec<f64> = self.planned.iter().zip(&self.other).map(|(p, o)| sign * (p - o)).collect();
        all.sort_by(f64::total_cmp);
        (median(&all), all.first().copied().unwrap_or(f64::NAN), all.last().copied().unwrap_or(f64::NAN))
    }
}

/// The median of sorted numbers.
fn median(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => f64::NAN,
        n => (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0,
    }
}

/// Measures every effect that can be chosen; `watch` hears of each. Also the seconds of a sample as planned, by run.
pub fn measure(
    scene: &Scene,
    device: &Device,
    options: &Options,
    settings: Settings,
    watch: &mut dyn FnMut(&str),
) -> Result<(Vec<f64>, Vec<Timing>), Error> {
    watch("as planned");
    let mut planned = Session::build(scene, device, options, false, &mut |_| {})?;
    let base = render(&mut planned)?.0;
    let mut seconds = Vec::new();
    for _ in 0..settings.runs {
        seconds.push(render(&mut planned)?.1);
    }
    let decisions: Vec<Decision> = planned.plan().decisions.clone();
    let mut timings = Vec::new();
    for decision in &decisions {
        let effect = decision.effect;
        let (change, changed) = match decision.is_on() {
            _ if effect.is_convention() || decision.removed => continue,
            true => (Change::Without, options.choices.overrides.and_without(effect)),
            false if !settings.forced || effect == Effect::DoublePrecision => continue,
            false => (Change::Forced, options.choices.overrides.and_force(effect)),
        };
        // Without the precision of the user's choice it is another one that is measured.
        if effect == Effect::DoublePrecision {
            continue;
        }
        watch(effect.name());
        let options = Options { choices: Choices { overrides: changed, ..options.choices }, ..*options };
        let cost = Session::build(scene, device, &options, false, &mut |_| {})
            .and_then(|mut other| compare(&mut planned, &mut other, &base, settings.runs).map(|c| (c, other)))
            .map_err(|e| e.to_string());
        let (cost, also) = match cost {
            Ok((cost, other)) => {
                let differs = |d: &&Decision| {
                    let before = decisions.iter().find(|b| b.effect == d.effect);
                    d.effect != effect && before.is_some_and(|b| b.is_on() != d.is_on())
                };
                let also = other.plan().decisions.iter().filter(differs).map(|d| d.effect).collect();
                (Ok(cost), also)
            }
            Err(cause) => (Err(cause), Vec::new()),
        };
        timings.push(Timing { effect, change, also, cost });
    }
    Ok((seconds, timings))
}

/// Renders turn by turn, so that what else the machine does meets both alike.
fn compare(planned: &mut Session<'_>, other: &mut Session<'_>, base: &Picture, runs: u32) -> Result<Cost, Error> {
    let (picture, _) = render(other)?;
    let mut cost = Cost { planned: Vec::new(), other: Vec::new(), difference: difference(base, &picture) };
    for _ in 0..runs {
        cost.planned.push(render(planned)?.1);
        cost.other.push(render(other)?.1);
    }
    Ok(cost)
}

/// A picture, and the seconds of one of its samples.
fn render(session: &mut Session<'_>) -> Result<(Picture, f64), Error> {
    let (picture, summary) = session.render(&mut |_| {})?;
    Ok((picture, summary.render_time.as_secs_f64() / f64::from(summary.samples.max(1))))
}

fn difference(a: &Picture, b: &Picture) -> f64 {
    // What has no alpha has no holes.
    let alpha = |p: &Picture, i: usize| f64::from(p.alpha.get(i).copied().unwrap_or(1.0));
    let (mut off, mut all) = (0.0, 0.0);
    for (i, (x, y)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        for (x, y) in x.iter().zip(y) {
            off += f64::from((x - y).abs());
            all += f64::from(x.abs());
        }
        off += (alpha(a, i) - alpha(b, i)).abs();
    }
    match (off > 0.0, all > 0.0) {
        (false, _) => 0.0,
        (true, true) => off / all,
        (true, false) => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_effect_takes_is_what_leaving_it_out_saves() {
        let cost = Cost { planned: vec![3.0, 4.0, 5.0], other: vec![1.0, 1.0, 4.0], difference: 0.0 };
        assert_eq!(cost.seconds(Change::Without), (2.0, 1.0, 3.0));
        assert_eq!(cost.seconds(Change::Forced), (-2.0, -3.0, -1.0));
    }
}
