//! The one table of OSL's built-in functions and closures: a row each.
//!
//! In: nothing. Out: [`Row`]s and [`ClosureRow`]s that checker, lowering, interpreter and back ends look up by handle.
//! It must not know the syntax tree or any target.
//!
//! A row's kernel function is named `osl_NAME_RET_ARGS`, where RET and ARGS are the codes of [`crate::ir::Ty`] (`n` for no
//! result); an output argument is `o` and its code, an array `a` and its code (a pointer, then its length as `int`):
//! `osl_dot_f_vv`, `osl_sincos_n_fofof`, `osl_spline_linear_f_faf`. Rows that read renderer state take
//! `const ShaderGlobals *sg` first.

mod closures;
pub mod derivative;
pub mod sig;
mod table;

pub use closures::{CLOSURES, ClosureRole, ClosureRow, UNKNOWN};
pub use table::TABLE;

/// Handle of a row of [`TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FuncId(pub u16);

/// Handle of a row of [`CLOSURES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClosureId(pub u16);

/// How a built-in reaches the IR and the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lowering {
    /// A scalar function; triples apply it to each component (a triple's `float` arguments are used for each).
    /// The kernel function has the triple form too, so the IR holds one call.
    Componentwise,
    /// One IR call to the kernel function of the chosen overload.
    Direct,
    /// As `Direct`, and the kernel function reads `ShaderGlobals`.
    State,
    /// `lower` rewrites it (kind and space strings, array lengths, constants); see `lower::special`.
    Special,
    /// Not callable by users: the target of a `Special` rewrite. As `Direct` otherwise.
    Internal,
    /// As `Internal`, and the kernel function reads `ShaderGlobals`.
    InternalState,
    /// As `Internal`, but a statement that is kept for what it does (see [`crate::messages`]).
    InternalEffect,
    /// One IR call that the passes must get rid of, by folding it on the host or with the branch around it; one that stays
    /// is answered "not supported yet" (`passes::review`).
    Host,
    /// As `Host`, and not callable by users.
    InternalHost,
    /// One IR call that does nothing or gives 0, as in the reference, which warns (`passes::review`).
    NotYet,
}

impl Lowering {
    /// Whether users can call it.
    pub fn is_public(self) -> bool {
        !matches!(
            self,
            Lowering::Internal | Lowering::InternalState | Lowering::InternalEffect | Lowering::InternalHost
        )
    }
}

/// One built-in function.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// OSL's name.
    pub name: &'static str,
    /// Overloads in order of preference: `float(vector,vector)`. `T` stands for float and each triple, `triple` for
    /// color, point, vector, normal, `ptype` for point, vector, normal (the same throughout a signature);
    /// `out ` marks output arguments, `[]` arrays of any length, `...` any further arguments.
    pub overloads: &'static [&'static str],
    /// How it is lowered.
    pub lowering: Lowering,
}

/// The row with this name that users can call or, for internal names, that `lower` targets.
pub fn find(name: &str) -> Option<FuncId> {
    sig::by_name(name)
}

/// The row behind a handle.
pub fn row(id: FuncId) -> &'static Row {
    &TABLE[id.0 as usize]
}

/// Whether a call does something beyond its results, so that it must stay, in its place among the others of its kind.
pub fn has_effect(id: FuncId) -> bool {
    row(id).lowering == Lowering::InternalEffect
}

/// The closure with this name.
pub fn find_closure(name: &str) -> Option<ClosureId> {
    CLOSURES.iter().position(|row| row.name == name).map(|i| ClosureId(i as u16))
}

/// The row behind a closure handle.
pub fn closure(id: ClosureId) -> &'static ClosureRow {
    &CLOSURES[id.0 as usize]
}
