//! The intermediate representation: one shader as typed values in structured control flow.
//!
//! In: built by [`crate::lower`], rewritten by [`crate::passes`]. Out: read by the back ends after [`verify`].
//! It must not know the syntax tree or any target.
//!
//! Shape of the language:
//! - Structs are gone (one variable per field, arrays of structs became structs of arrays), functions are inlined,
//!   `return` and `exit` became structured control flow, `&& || ?:` with effects became [`Stmt::If`].
//! - A [`Value`] is computed once, where its [`Stmt::Let`] stands, and is visible after that in the same block and the
//!   blocks nested in it. Mutable state lives in [`Local`]s only.
//! - Operands of [`Inst::Binary`] have equal types; conversions are explicit.
//! - Parameters and shader globals are locals as well ([`LocalKind`]): their init runs before the body.

mod forms;
mod inputs;
mod print;
mod read;
mod rewrite;
mod verify;
mod visit;

pub use inputs::{InputLayout, numbers, slots_of};
pub use print::print;
pub use read::{ReadError, read};
pub use rewrite::Rewriter;
pub use verify::{VerifyError, verify};

use crate::builtins;
use crate::source::Span;
use crate::types;
pub use crate::types::Traits;

/// A type of the IR. Triples lose their kind: what depends on it (transforms) is resolved by `lower`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ty {
    /// 32-bit two's complement, wrapping.
    Int,
    /// The working precision.
    Float,
    /// Three floats: color, point, vector, normal.
    Triple,
    /// 16 floats, row-major; OSL multiplies row vectors from the left.
    Matrix,
    /// Interned string.
    Str,
    /// Linear combination of lobe slots. No closure is left after `passes::closures`.
    Closure,
}

impl Ty {
    /// One letter for mangled names: `i f v m s c`.
    pub fn code(self) -> char {
        match self {
            Ty::Int => 'i',
            Ty::Float => 'f',
            Ty::Triple => 'v',
            Ty::Matrix => 'm',
            Ty::Str => 's',
            Ty::Closure => 'c',
        }
    }
}

/// Handle of a [`Local`] of the same [`Shader`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LocalId(pub u32);

/// Handle of a [`Value`] of the same [`Shader`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ValueId(pub u32);

/// Shader globals (OSL specification ch. 6, "Global variables"), and the derivatives of some of them by the pixel's x and y,
/// which only passes put in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // The specification's names.
pub enum Global {
    P,
    I,
    N,
    Ng,
    U,
    V,
    DPdu,
    DPdv,
    Ps,
    Time,
    DTime,
    DPdtime,
    Ci,
    DPdx,
    DPdy,
    DIdx,
    DIdy,
    DPsdx,
    DPsdy,
    DUdx,
    DUdy,
    DVdx,
    DVdy,
}

impl Global {
    /// All of them, in declaration order.
    pub const ALL: [Global; 23] = {
        use Global::*;
        [
            P, I, N, Ng, U, V, DPdu, DPdv, Ps, Time, DTime, DPdtime, Ci, DPdx, DPdy, DIdx, DIdy, DPsdx, DPsdy, DUdx,
            DUdy, DVdx, DVdy,
        ]
    };

    /// OSL's spelling; also the field name of `ShaderGlobals` in kernels/globals.h.
    pub fn name(self) -> &'static str {
        use Global::*;
        match self {
            P => "P",
            I => "I",
            N => "N",
            Ng => "Ng",
            U => "u",
            V => "v",
            DPdu => "dPdu",
            DPdv => "dPdv",
            Ps => "Ps",
            Time => "time",
            DTime => "dtime",
            DPdtime => "dPdtime",
            Ci => "Ci",
            DPdx => "dPdx",
            DPdy => "dPdy",
            DIdx => "dIdx",
            DIdy => "dIdy",
            DPsdx => "dPsdx",
            DPsdy => "dPsdy",
            DUdx => "dudx",
            DUdy => "dudy",
            DVdx => "dvdx",
            DVdy => "dvdy",
        }
    }

    /// Its type in the IR.
    pub fn ty(self) -> Ty {
        use Global::*;
        match self {
            P | I | N | Ng | DPdu | DPdv | Ps | DPdtime => Ty::Triple,
            U | V | Time | DTime => Ty::Float,
            Ci => Ty::Closure,
            DPdx | DPdy | DIdx | DIdy | DPsdx | DPsdy => Ty::Triple,
            DUdx | DUdy | DVdx | DVdy => Ty::Float,
        }
    }

    /// The global that it is a derivative of; itself when it is none.
    pub fn base(self) -> Global {
        use Global::*;
        match self {
            DPdx | DPdy => P,
            DIdx | DIdy => I,
            DPsdx | DPsdy => Ps,
            DUdx | DUdy => U,
            DVdx | DVdy => V,
            other => other,
        }
    }

    /// Whether it is a derivative of another.
    pub fn is_derivative(self) -> bool {
        self.base() != self
    }
}

/// Where a local comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalKind {
    /// A variable of the user or of the compiler. Holds zero / "" / the null closure until stored.
    Variable,
    /// The parameter with this index in [`Shader::params`].
    Param(u32),
    /// A shader global, loaded from the renderer before anything runs.
    Global(Global),
    /// The input with this index in [`Shader::inputs`], loaded from the renderer before anything runs; never written.
    Input(u32),
}

/// Where an input comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Data of the geometry at the point, by the parameter's name.
    Userdata,
    /// Int: whether the geometry has the userdata of this name here.
    HasUserdata,
    /// The present value of an interactive parameter.
    Interactive,
    /// Int: whether the interactive parameter of this name has a value that stands for its default.
    HasInteractive,
}

impl Source {
    /// One word for printed IR.
    pub fn name(self) -> &'static str {
        match self {
            Source::Userdata => "userdata",
            Source::HasUserdata => "has_userdata",
            Source::Interactive => "interactive",
            Source::HasInteractive => "has_interactive",
        }
    }
}

/// A value that the renderer supplies beside the globals.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Of userdata its name; of an interactive parameter its flattened name, in a group with its layer in front.
    pub name: String,
    /// Where it comes from.
    pub source: Source,
    /// Its type and length in OSL.
    pub declared: types::Type,
    /// Element type.
    pub ty: Ty,
    /// Array length; `None` for a single value.
    pub len: Option<u32>,
    /// What an interactive parameter starts with; an array for arrays. Userdata has none.
    pub default: Option<Const>,
}

/// A mutable variable of the shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Local {
    /// Name for people and for readable output; need not be unique. Flattened fields are `a.x`.
    pub name: String,
    /// Element type.
    pub ty: Ty,
    /// Array length; `None` for a single value.
    pub len: Option<u32>,
    /// Where it comes from.
    pub kind: LocalKind,
}

/// A constant. Floats are kept in f64 and rounded by the target.
#[derive(Clone, Debug, PartialEq)]
pub enum Const {
    /// `Int`
    Int(i32),
    /// `Float`
    Float(f64),
    /// `Triple`
    Triple([f64; 3]),
    /// `Matrix`, row-major
    Matrix([f64; 16]),
    /// `Str`
    Str(String),
    /// Elements of an array, all of one type. Only as parameter values, never as an [`Inst::Const`].
    Array(Vec<Const>),
}

impl Const {
    /// The type; of the elements for arrays (`None` when empty).
    pub fn ty(&self) -> Option<Ty> {
        Some(match self {
            Const::Int(_) => Ty::Int,
            Const::Float(_) => Ty::Float,
            Const::Triple(_) => Ty::Triple,
            Const::Matrix(_) => Ty::Matrix,
            Const::Str(_) => Ty::Str,
            Const::Array(items) => return items.first().and_then(Const::ty),
        })
    }
}

/// A parameter after flattening (`a.x` for field x of struct parameter a).
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Flattened name.
    pub name: String,
    /// OSL type of this flattened parameter (never a struct).
    pub declared: types::Type,
    /// Declared `output`.
    pub output: bool,
    /// The local that holds it. An unsized array gets its length when bound; until then that of its default.
    pub local: LocalId,
    /// `[[ int lockgeom = 0 ]]`, `interpolated` or `interactive`: must not be folded. `passes::link` makes what such a
    /// parameter reads explicit and sets this to false.
    pub varying: bool,
    /// Stores the default into the local ("init ops"); may read earlier parameters and globals.
    /// `specialise` replaces it by the bound value.
    pub init: Block,
    /// The name in the shader source.
    pub span: Span,
    /// What else its declaration says.
    pub traits: Traits,
}

/// A closure call after `passes::closures`: a lobe whose weight and arguments sit in locals (or constants).
#[derive(Clone, Debug, PartialEq)]
pub struct LobeSlot {
    /// Which closure.
    pub closure: builtins::ClosureId,
    /// Local of type `Triple`: the lobe's weight in Ci when the shader ends (zero when the call was not reached).
    pub weight: LocalId,
    /// One per formal argument, then one per token of the closure's row. The tint went into the weight: it is the constant 1.
    pub args: Vec<SlotArg>,
    /// The call.
    pub span: Span,
}

/// An argument of a lobe slot.
#[derive(Clone, Debug, PartialEq)]
pub enum SlotArg {
    /// Known at compile time.
    Const(Const),
    /// Read from a local when the shader ends.
    Local(LocalId),
}

/// A shader in the IR.
#[derive(Clone, Debug, PartialEq)]
pub struct Shader {
    /// Its name in OSL.
    pub name: String,
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: String,
    /// Parameters in declaration order.
    pub params: Vec<Param>,
    /// All locals.
    pub locals: Vec<Local>,
    /// All values; a value's operands have smaller ids.
    pub values: Vec<Value>,
    /// Runs after the params' inits.
    pub body: Block,
    /// Filled by `passes::closures`; empty before it.
    pub slots: Vec<LobeSlot>,
    /// Filled by `passes::link`; empty before it.
    pub inputs: Vec<Input>,
    /// The calls whose derivatives `passes::derivatives` has written out; empty before it. Printed IR does not have them.
    pub derivative_uses: Vec<Span>,
}

/// A computed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// What computes it.
    pub inst: Inst,
    /// Its type.
    pub ty: Ty,
    /// Place in the source, for diagnostics and #line.
    pub span: Span,
}

/// Computes one value from others. Pure but for loads.
#[derive(Clone, Debug, PartialEq)]
pub enum Inst {
    /// A constant (no array).
    Const(Const),
    /// The value of a non-array local, now.
    Load(LocalId),
    /// An element of an array local; the index is clamped into range (OSL: out of range is an error, the nearest
    /// element is used).
    LoadElem(LocalId, ValueId),
    /// One operand.
    Unary(UnaryOp, ValueId),
    /// Two operands of one type.
    Binary(BinaryOp, ValueId, ValueId),
    /// Conversion to the value's type; see [`Inst::convertible`].
    Convert(ValueId),
    /// Three floats to a triple.
    Triple([ValueId; 3]),
    /// Sixteen floats to a matrix, row-major.
    Matrix(Box<[ValueId; 16]>),
    /// Component of a triple; the index is clamped to 0..=2.
    Component(ValueId, ValueId),
    /// Element row, column of a matrix; indices are clamped to 0..=3.
    MatrixElement(ValueId, ValueId, ValueId),
    /// The triple (first) with component (second) replaced by the float (third).
    WithComponent(ValueId, ValueId, ValueId),
    /// The matrix (first) with element row (second), column (third) replaced by the float (fourth).
    WithMatrixElement(ValueId, ValueId, ValueId, ValueId),
    /// `cond != 0 ? a : b`, both evaluated; a, b of the value's type.
    Select(ValueId, ValueId, ValueId),
    /// A built-in without effects and outputs.
    Call(builtins::FuncId, Vec<Arg>),
    /// A closure call: one lobe with weight 1. Arguments: the formal ones, a value per token of the row, and a label (a string)
    /// if the call has one.
    Closure(builtins::ClosureId, Vec<ValueId>),
    /// The empty closure.
    NullClosure,
    /// Sum of two closures.
    AddClosure(ValueId, ValueId),
    /// Closure (first) times a triple or float (second).
    ScaleClosure(ValueId, ValueId),
    /// The first closure over the second, which is scaled by one minus the first's directional albedo.
    Layer(ValueId, ValueId),
    /// The directional albedo towards the viewer of a lobe, per channel, 0..1 (`Triple`). Arguments as in a [`LobeSlot`]; the tint is
    /// not part of it.
    Albedo(builtins::ClosureId, Vec<ValueId>),
    /// 1 when the closure is not empty (has a component whose weight was made, even if it is zero), else 0.
    ClosureIsSet(ValueId),
}

impl Inst {
    /// Whether `Convert` takes `from` to `to`: int -> float; float -> int (truncates; the smallest int where none fits);
    /// float -> triple (splat); float -> matrix (diagonal); triple/float/int/str/matrix -> int is not a conversion
    /// but `!= 0`, which lower writes as comparisons.
    pub fn convertible(from: Ty, to: Ty) -> bool {
        matches!(
            (from, to),
            (Ty::Int, Ty::Float) | (Ty::Float, Ty::Int) | (Ty::Float, Ty::Triple) | (Ty::Float, Ty::Matrix)
        )
    }
}

/// An argument of a built-in: a value, or a whole array variable by reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arg {
    /// A value.
    Value(ValueId),
    /// An array local, read (in [`Inst::Call`]) or also written (in an output place of [`Stmt::Call`]).
    Array(LocalId),
}

/// One-operand operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// Int, Float, Triple, Matrix.
    Neg,
    /// Int: bitwise complement.
    Compl,
    /// Int: 1 when zero, else 0.
    Not,
}

/// Two-operand operators. OSL's defined results hold: x/0 = 0, x%0 = 0, INT_MIN / -1 wraps; `Mod` is C's `%` for ints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The names are the operators'.
pub enum BinaryOp {
    /// Int, Float, Triple.
    Add,
    /// Int, Float, Triple.
    Sub,
    /// Int, Float, Triple; Matrix: product.
    Mul,
    /// Int, Float, Triple; Matrix: by the inverse (singular: zero matrix... see `runtime` tables).
    Div,
    /// Int.
    Mod,
    /// Any type but closure; triples and matrices when all components are equal. Result Int.
    Eq,
    /// The negation of Eq.
    Ne,
    /// Int, Float. Result Int.
    Lt,
    /// As Lt.
    Le,
    /// As Lt.
    Gt,
    /// As Lt.
    Ge,
    /// Int.
    BitAnd,
    /// Int.
    BitOr,
    /// Int.
    BitXor,
    /// Int; the count is taken modulo 32.
    Shl,
    /// Int, arithmetic; the count is taken modulo 32.
    Shr,
}

/// A sequence of statements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    /// In order.
    pub stmts: Vec<Stmt>,
}

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub enum Stmt {
    /// Computes the value here.
    Let(ValueId),
    /// Sets a non-array local.
    Store(LocalId, ValueId),
    /// Sets an element (index clamped into range) of an array local.
    StoreElem(LocalId, ValueId, ValueId),
    /// Copies the first elements of the second array to the first; as many as the shorter has.
    CopyArray(LocalId, LocalId),
    /// A built-in that writes to places: `func(args, outputs)`; `result` when it returns a value too.
    Call {
        /// Which.
        func: builtins::FuncId,
        /// Inputs, in order.
        args: Vec<Arg>,
        /// Outputs in the order of the declaration: non-array locals or arrays.
        outputs: Vec<LocalId>,
        /// Where the return value goes.
        result: Option<LocalId>,
        /// The call.
        span: Span,
    },
    /// Condition of type Int.
    If(ValueId, Block, Block),
    /// Repeats: `body; if (!cond) leave; step`. `before` holds the condition's computation.
    Loop(Box<Loop>),
    /// Leaves the innermost loop.
    Break,
    /// Goes on with `step` of the innermost loop.
    Continue,
}

/// A loop: `for (;;) { head; if (!cond) break; body; step }`, or with `tested_after` (do-while)
/// `for (;;) { body; head; if (!cond) break; step }`. `continue` goes to what follows `body`.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Computes `cond`.
    pub head: Block,
    /// Int; visible from `head`.
    pub cond: ValueId,
    /// do-while.
    pub tested_after: bool,
    /// The body; `Break` and `Continue` refer to this loop.
    pub body: Block,
    /// Runs before the next turn; holds no `Break` or `Continue` of this loop.
    pub step: Block,
}
