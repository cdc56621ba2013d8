//! What accuracy costs: errors of repeated renders against a reference, with how sure they are, and who lies on the front.
//!
//! In: pictures of several seeds, times, a reference. Out: [`Measured`] per setting, [`pareto`], plots as SVG. It must not know
//! how pictures are made.

mod pareto;
pub mod plot;
mod statistics;

pub use pareto::pareto;
pub use statistics::{Estimate, Measured, Run, estimate, measure};
