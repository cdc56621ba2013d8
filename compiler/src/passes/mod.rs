//! Passes: functions from IR to IR, one per file.
//!
//! In: verified IR. Out: verified IR that computes the same. [`optimise`] is the list that every shader goes through.
//! They must not know the syntax tree or any target.
//!
//! Codes: `E4001` unknown parameter, `E4002` value does not fit a parameter, `E4003` closures in a loop that cannot be
//! unrolled, `E4004` closures not supported yet here, `E4005` too many closure calls; of the review `E3001` a call that only
//! the host can carry out, `E3003` an unknown name, `W2003` an odd number of knots, `W3001` an unknown distribution.

mod closures;
mod dead;
mod fold;
pub mod link;
mod prune;
mod review;
mod specialise;
mod textures;
mod unroll;

pub use closures::closures;
pub use fold::fold;
pub use prune::prune;
pub use specialise::specialise;
pub use textures::{TextureUse, textures};

use crate::diag::Diagnostic;
use crate::ir::{Const, Shader, verify};
use crate::textures::TextureAccess;

/// Binds parameters and reduces the shader to what its lobes and the named output parameters need.
///
/// The list: specialise, fold (which unrolls loops with closure calls), answers about textures, closures, fold, prune; the last two again, since
/// dropping a slot or a branch may free more; then a review of what is left, whose warnings are returned.
pub fn optimise(
    shader: &mut Shader,
    bindings: &[(String, Const)],
    outputs: &[String],
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    optimise_with(shader, bindings, outputs, None)
}

/// As [`optimise`], with somebody who answers `gettextureinfo`.
pub fn optimise_with(
    shader: &mut Shader,
    bindings: &[(String, Const)],
    outputs: &[String],
    files: Option<&TextureAccess>,
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let _span = tracing::debug_span!("optimise", shader = shader.name).entered();
    let check = |shader: &Shader, pass: &str| {
        if (cfg!(debug_assertions) || cfg!(test))
            && let Err(e) = verify(shader)
        {
            unreachable!("pass {pass} broke the IR: {e}");
        }
    };
    check(shader, "lower");
    specialise(shader, bindings)?;
    check(shader, "specialise");
    fold(shader)?;
    check(shader, "fold");
    textures::answer(shader, files)?;
    check(shader, "textures");
    closures(shader)?;
    check(shader, "closures");
    fold(shader)?;
    check(shader, "fold");
    review::refuse_calls(shader)?;
    prune(shader, outputs);
    check(shader, "prune");
    let reduce = |shader: &mut Shader| {
        fold(shader)?;
        check(shader, "fold");
        prune(shader, outputs);
        check(shader, "prune");
        Ok::<(), Vec<Diagnostic>>(())
    };
    reduce(shader)?;
    let (warnings, changed) = review::review(shader)?;
    if changed {
        check(shader, "review");
        reduce(shader)?;
    }
    textures::textures(shader)?;
    tracing::debug!(values = shader.values.len(), slots = shader.slots.len(), "optimised");
    Ok(warnings)
}
