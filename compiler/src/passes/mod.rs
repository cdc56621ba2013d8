//! Passes: functions from IR to IR, one per file.
//!
//! In: verified IR. Out: verified IR that computes the same. [`optimise`] is the list that every shader goes through.
//! They must not know the syntax tree or any target.
//!
//! Codes: `E4001` unknown parameter, `E4002` value does not fit a parameter, `E4003` closures in a loop that cannot be
//! unrolled, `E4004` closures not supported yet here, `E4005` too many closure calls; of the review `E3001` a call that only
//! the host can carry out, `E3003` an unknown name, `W2003` an odd number of knots, `W3001` an unknown distribution.

mod cases;
mod closures;
mod clouds;
mod controls;
mod counters;
mod dead;
mod derivatives;
mod dialogue;
mod dictionary;
mod fold;
pub mod link;
mod named;
mod numbers;
mod printed;
mod prune;
mod review;
mod specialise;
mod strings;
mod textures;
mod traces;
mod unroll;
mod zeros;

pub use closures::closures;
pub use clouds::clouds;
pub(crate) use controls::Controls;
pub use derivatives::derivatives;
pub use fold::fold;
pub use prune::prune;
pub use specialise::specialise;
pub(crate) use specialise::{fitted, length_of};
pub(crate) use textures::is_lookup;
pub use textures::{TextureUse, textures};
pub use traces::{Traces, traces};

use crate::attributes::Attributes;
use crate::builtins;
use crate::diag::Diagnostic;
use crate::dictionary::Documents;
use crate::ir::{Arg, Const, Inst, Shader, Stmt, verify};
use crate::source::SourceMap;
use crate::textures::TextureAccess;

/// Rounds of `cases`: functions of choices inside each other.
const MAX_ROUNDS: u32 = 16;

/// Who carries out the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Target {
    /// An OpenCL device: strings are ids, so that what looks into them has to be gone.
    #[default]
    Device,
    /// The interpreter.
    Host,
}

/// What a run of the passes depends on beside the shader.
#[derive(Clone, Copy, Default)]
pub struct Settings<'a> {
    /// Who carries out the result.
    pub target: Target,
    /// Who answers `gettextureinfo`.
    pub textures: Option<&'a TextureAccess>,
    /// What `getattribute` finds.
    pub attributes: Option<&'a Attributes>,
    /// Who reads the files of dictionaries.
    pub documents: Option<&'a Documents>,
    /// Where spans lie, for what is said at run time of places in the source.
    pub sources: Option<&'a SourceMap>,
    /// The shader runs over a grid of points, without a scene.
    pub grid: bool,
    /// The bits of all rays that come, if they are known.
    pub ray_types: Option<u32>,
    /// What rays of `trace` can meet.
    pub rays: Rays,
}

/// What there is for rays of `trace` to meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rays {
    /// A scene.
    #[default]
    Scene,
    /// Nothing; the answers are those of the reference implementation's testshade, which has no scene either.
    Pretended,
    /// Nothing yet: the scene is built from what the shader says.
    Nothing,
}

/// Binds parameters and reduces the shader to what its lobes and the named output parameters need, for a device.
pub fn optimise(
    shader: &mut Shader,
    bindings: &[(String, Const)],
    outputs: &[String],
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    optimise_with(shader, bindings, outputs, &Settings::default())
}

/// As [`optimise`], with settings.
///
/// The list: specialise, fold (which unrolls loops with closure calls), answers about textures, dictionaries, traced rays and
/// messages (behind the cases of texts that these are asked by), closures, fold, zeros, fold, cases, fold, prune; the last two again,
/// since dropping a slot or a branch may free more; then a review of what is left, whose warnings are returned; last the
/// derivatives, of what is still used, and fold and prune again where there are any.
pub fn optimise_with(
    shader: &mut Shader,
    bindings: &[(String, Const)],
    outputs: &[String],
    settings: &Settings<'_>,
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let _span = tracing::debug_span!("optimise", shader = shader.name).entered();
    check(shader, "lower");
    link::settle_alone(shader);
    specialise(shader, bindings)?;
    check(shader, "specialise");
    if let Some(bits) = settings.ray_types {
        known_ray_types(shader, bits);
    }
    // Names of textures, messages and attributes are constants where the loops around them are unrolled.
    fold::fold_with(shader, true)?;
    check(shader, "fold");
    textures::answer(shader, settings.textures)?;
    check(shader, "textures");
    early_cases(shader, settings)?;
    dictionary::dictionary(shader, settings)?;
    check(shader, "dictionary");
    if named::named(shader) {
        check(shader, "named");
    }
    let mut said = traces::answer(shader, settings.rays)?;
    check(shader, "traces");
    said.extend(clouds::answer(shader, settings.rays));
    check(shader, "clouds");
    dialogue::dialogue(shader, settings.sources)?;
    check(shader, "dialogue");
    closures(shader)?;
    check(shader, "closures");
    fold(shader)?;
    check(shader, "fold");
    if zeros::zeros(shader) {
        check(shader, "zeros");
        fold::fold_with(shader, settings.target == Target::Device)?;
        check(shader, "fold");
    }
    if settings.target == Target::Device {
        printed::printed(shader);
        check(shader, "printed");
    }
    all_cases(shader, settings)?;
    said.extend(review::refuse_calls(shader, settings)?);
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
    if not_constant(shader) {
        reduce(shader)?;
    }
    let (warnings, changed) = review::review(shader, settings.target)?;
    if changed {
        check(shader, "review");
        reduce(shader)?;
    }
    if derivatives(shader) {
        check(shader, "derivatives");
        reduce(shader)?;
    }
    textures::textures(shader)?;
    traces::traces(shader)?;
    if settings.target == Target::Device {
        clouds::clouds(shader)?;
    }
    tracing::debug!(values = shader.values.len(), slots = shader.slots.len(), "optimised");
    said.extend(warnings);
    Ok(said)
}

/// In builds for development: what a pass leaves is sound.
fn check(shader: &Shader, pass: &str) {
    if (cfg!(debug_assertions) || cfg!(test))
        && let Err(e) = verify(shader)
    {
        unreachable!("pass {pass} broke the IR: {e}");
    }
}

/// Carries out what only the host can, case by case. What a case yields may be a choice again, of which the next call has cases.
fn all_cases(shader: &mut Shader, settings: &Settings<'_>) -> Result<(), Vec<Diagnostic>> {
    let mut rounds = 0;
    while rounds < MAX_ROUNDS && cases::cases(shader, settings)? {
        check(shader, "cases");
        fold(shader)?;
        check(shader, "fold");
        rounds += 1;
    }
    Ok(())
}

/// Dictionaries and messages are asked by texts that may have to be made first.
fn early_cases(shader: &mut Shader, settings: &Settings<'_>) -> Result<(), Vec<Diagnostic>> {
    let asks = |name| matches!(name, "dict_find" | "dict_get" | "message_get" | "message_set");
    let mut found = shader.values.iter().any(|v| matches!(&v.inst, Inst::Call(f, _) if asks(builtins::row(*f).name)));
    for block in shader.blocks() {
        block.walk(&mut |s| found |= matches!(s, Stmt::Call { func, .. } if asks(builtins::row(*func).name)));
    }
    if found { all_cases(shader, settings) } else { Ok(()) }
}

/// Answers `raytype`.
fn known_ray_types(shader: &mut Shader, bits: u32) {
    let Some(row) = builtins::find("raytype_bit") else { return };
    for i in 0..shader.values.len() {
        let Inst::Call(func, args) = &shader.values[i].inst else { continue };
        let asked = match args.as_slice() {
            [Arg::Value(v)] if *func == row => match shader.values[v.0 as usize].inst {
                Inst::Const(Const::Int(bit)) => bit,
                _ => continue,
            },
            _ => continue,
        };
        shader.values[i].inst = Inst::Const(Const::Int((bits & asked as u32 != 0).into()));
    }
}

/// Answers `isconstant` with 0 where folding found no constant; whether there was such a call.
fn not_constant(shader: &mut Shader) -> bool {
    let Some(row) = builtins::find("is_constant") else { return false };
    let mut changed = false;
    for value in &mut shader.values {
        if matches!(value.inst, Inst::Call(func, _) if func == row) {
            value.inst = Inst::Const(Const::Int(0));
            changed = true;
        }
    }
    changed
}
