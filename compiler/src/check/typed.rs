//! The typed tree: what [`super::check`] yields and [`crate::lower`] reads.
//!
//! Names are bound to handles, overloads are chosen, implicit conversions are [`ExprKind::Convert`] nodes.

use crate::ast::{BinaryOp, IncDecOp};
use crate::builtins::{ClosureId, FuncId};
use crate::source::Span;
use crate::types::{Base, StructId, Traits, Type};

/// Handle of a [`Var`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VarId(pub u32);

/// Handle of a [`Function`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FunctionId(pub u32);

/// What a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VarKind {
    /// A shader global, by its OSL name ([`Var::name`]).
    Global,
    /// The shader parameter with this index.
    ShaderParam(u32),
    /// A function's parameter.
    FunctionParam,
    /// A local variable.
    Local,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Var {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// What it is.
    pub kind: VarKind,
    /// Whether it may be assigned.
    pub writable: bool,
    /// Its declaration.
    pub span: Span,
}

/// A struct's layout.
#[derive(Clone, Debug)]
pub struct Struct {
    /// Its name.
    pub name: String,
    /// Fields in order.
    pub fields: Vec<(String, Type)>,
}

/// A user's function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Result.
    pub ret: Type,
    /// Parameters: the variable, and whether it is `output`.
    pub params: Vec<(VarId, bool)>,
    /// `None`: declared only.
    pub body: Option<Vec<Stmt>>,
    /// How it stands for a closure.
    pub closure: VendorClosure,
    /// The declaration.
    pub span: Span,
}

/// Whether a function stands for a closure of another renderer (`crate::vendor`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VendorClosure {
    /// It does not.
    No,
    /// A header declares it, and no mapping says what it looks like: it contributes nothing.
    Unknown,
    /// A mapping's function, whose last so many parameters are given by token/value pairs.
    Mapped {
        /// How many.
        tokens: u32,
    },
}

/// A shader parameter.
#[derive(Clone, Debug)]
pub struct Param {
    /// The variable.
    pub var: VarId,
    /// Declared `output`.
    pub output: bool,
    /// Default value; `None` for an empty list.
    pub init: Option<Expr>,
    /// `lockgeom = 0`, `interpolated = 1` or `interactive = 1` in its metadata.
    pub varying: bool,
    /// What else is said of it.
    pub traits: Traits,
}

/// A checked shader with all that it calls.
#[derive(Clone, Debug)]
pub struct Shader {
    /// Name.
    pub name: String,
    /// Kind as written.
    pub kind: String,
    /// Parameters.
    pub params: Vec<Param>,
    /// Body.
    pub body: Vec<Stmt>,
    /// All variables of the file.
    pub vars: Vec<Var>,
    /// All structs of the file.
    pub structs: Vec<Struct>,
    /// All functions of the file.
    pub functions: Vec<Function>,
}

impl Shader {
    /// The variable behind a handle of this shader.
    pub fn var(&self, id: VarId) -> &Var {
        &self.vars[id.0 as usize]
    }

    /// The struct behind a handle of this shader.
    pub fn structure(&self, id: StructId) -> &Struct {
        &self.structs[id.0 as usize]
    }
}

/// A typed expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Which.
    pub kind: ExprKind,
    /// Type of the result.
    pub ty: Type,
    /// Where.
    pub span: Span,
}

impl Expr {
    /// Whether it names a place that can be written.
    pub fn is_place(&self) -> bool {
        match &self.kind {
            ExprKind::Var(_) => true,
            ExprKind::Index(base, _)
            | ExprKind::Component(base, _)
            | ExprKind::Element(base, ..)
            | ExprKind::Field(base, _) => base.is_place(),
            _ => false,
        }
    }
}

/// What a call goes to.
#[derive(Clone, Debug)]
pub enum Callee {
    /// A user's function.
    User(FunctionId),
    /// A built-in with the types of the chosen overload's formals; `outputs[i]` tells whether argument i is written.
    /// Optional arguments behind the formals have no entry.
    Builtin {
        /// The row.
        id: FuncId,
        /// Formal types of the chosen overload.
        formals: Vec<Type>,
        /// Which are outputs.
        outputs: Vec<bool>,
    },
    /// A closure; behind the `formals` follow a value per token of its row, and the label if the call has one.
    Closure {
        /// The row.
        id: ClosureId,
        /// Number of formal arguments.
        formals: usize,
    },
}

/// Expressions. Truth tests are [`ExprKind::Truth`]; conditions are ints after it.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// int
    Int(i32),
    /// float
    Float(f64),
    /// string
    Str(String),
    /// A variable as a whole.
    Var(VarId),
    /// Array element.
    Index(Box<Expr>, Box<Expr>),
    /// Component of a triple.
    Component(Box<Expr>, Box<Expr>),
    /// Matrix element: matrix, row, column.
    Element(Box<Expr>, Box<Expr>, Box<Expr>),
    /// Field of a struct by index.
    Field(Box<Expr>, u32),
    /// A call.
    Call(Callee, Vec<Expr>),
    /// `color(...)`, `matrix(...)`...: arguments are converted (floats, or leading strings for spaces).
    Construct(Vec<Expr>),
    /// A struct from its fields, or an array from its elements. Missing trailing array elements are undefined.
    List(Vec<Expr>),
    /// Conversion to the expression's type.
    Convert(Box<Expr>),
    /// `!= 0` of any type; int result.
    Truth(Box<Expr>),
    /// `-` (also of closures)
    Neg(Box<Expr>),
    /// `!` of an int
    Not(Box<Expr>),
    /// `~`
    Compl(Box<Expr>),
    /// Operands of equal type, closures aside (`closure * color`). `And`/`Or` take ints and short-circuit.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `++` and `--` on an int or float lvalue.
    IncDec(IncDecOp, Box<Expr>),
    /// `lhs = rhs`, both of the expression's type.
    Assign(Box<Expr>, Box<Expr>),
    /// `lhs op= rhs`: computed in the type of `rhs`, then converted to that of `lhs`.
    AssignOp(BinaryOp, Box<Expr>, Box<Expr>),
    /// Condition is an int.
    Ternary(Box<Expr>, Box<Expr>, Box<Expr>),
    /// Evaluates all, is the last.
    Comma(Vec<Expr>),
}

/// A typed statement.
#[derive(Clone, Debug)]
pub enum Stmt {
    /// A local variable comes to life.
    Declare(VarId, Option<Expr>),
    /// For its effect.
    Expr(Expr),
    /// A scope.
    Block(Vec<Stmt>),
    /// `if`
    If(Expr, Vec<Stmt>, Vec<Stmt>),
    /// Any loop. `init` ran before; the condition is an int, absent: true.
    Loop {
        /// Tested before each turn.
        cond: Option<Expr>,
        /// The condition is tested after the body (do-while).
        after: bool,
        /// After each turn.
        step: Option<Expr>,
        /// Body.
        body: Vec<Stmt>,
    },
    /// `break`
    Break,
    /// `continue`
    Continue,
    /// `return`
    Return(Option<Expr>, Span),
}

/// Visits an expression and all inside it; without recursion, since chains of operators may be long.
pub(crate) fn visit<'e>(e: &'e Expr, see: &mut dyn FnMut(&'e Expr)) {
    let mut todo = vec![e];
    while let Some(e) = todo.pop() {
        see(e);
        todo.extend(parts(e));
    }
}

/// The expressions right inside one.
pub(crate) fn parts(e: &Expr) -> impl Iterator<Item = &Expr> {
    let (few, many): ([Option<&Expr>; 3], &[Expr]) = match &e.kind {
        ExprKind::Int(_) | ExprKind::Float(_) | ExprKind::Str(_) | ExprKind::Var(_) => ([None; 3], &[]),
        ExprKind::Field(a, _)
        | ExprKind::Convert(a)
        | ExprKind::Truth(a)
        | ExprKind::Neg(a)
        | ExprKind::Not(a)
        | ExprKind::Compl(a)
        | ExprKind::IncDec(_, a) => ([Some(a), None, None], &[]),
        ExprKind::Index(a, b)
        | ExprKind::Component(a, b)
        | ExprKind::Binary(_, a, b)
        | ExprKind::Assign(a, b)
        | ExprKind::AssignOp(_, a, b) => ([Some(a), Some(b), None], &[]),
        ExprKind::Element(a, b, c) | ExprKind::Ternary(a, b, c) => ([Some(a), Some(b), Some(c)], &[]),
        ExprKind::Call(_, list) | ExprKind::Construct(list) | ExprKind::List(list) | ExprKind::Comma(list) => {
            ([None; 3], list)
        }
    };
    few.into_iter().flatten().chain(many)
}

/// The expressions of statements, outermost.
pub(crate) fn expressions<'e>(stmts: &'e [Stmt], see: &mut dyn FnMut(&'e Expr)) {
    for stmt in stmts {
        match stmt {
            Stmt::Declare(_, Some(e)) | Stmt::Expr(e) | Stmt::Return(Some(e), _) => see(e),
            Stmt::Block(b) => expressions(b, see),
            Stmt::If(c, a, b) => {
                see(c);
                expressions(a, see);
                expressions(b, see);
            }
            Stmt::Loop { cond, step, body, .. } => {
                cond.iter().chain(step).for_each(&mut *see);
                expressions(body, see);
            }
            _ => {}
        }
    }
}

impl Type {
    /// Result of functions that return nothing.
    pub(crate) const VOID: Type = Type::scalar(Base::Void);
    /// int
    pub(crate) const INT: Type = Type::scalar(Base::Int);
    /// float
    pub(crate) const FLOAT: Type = Type::scalar(Base::Float);
    /// string
    pub(crate) const STRING: Type = Type::scalar(Base::String);
}
