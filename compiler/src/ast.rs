//! The syntax tree of an OSL file, as written: no types resolved, no names bound.
//!
//! In: built by [`crate::parse`]. Out: read by [`crate::check`]. It must not know types beyond their spelling, nor the IR.

use crate::diag::Diagnostic;
use crate::source::Span;

/// A whole preprocessed file, in source order.
#[derive(Clone, Debug, Default)]
pub struct File {
    /// Functions, structs and shaders.
    pub items: Vec<Item>,
    /// Warnings about how it is written.
    pub warnings: Vec<Diagnostic>,
    /// Names in parts that could not be read: they may have been declared there.
    pub broken: Vec<String>,
}

/// A declaration at file level.
#[derive(Clone, Debug)]
pub enum Item {
    /// A shader.
    Shader(Shader),
    /// A function, with or without body.
    Function(Function),
    /// A struct.
    Struct(Struct),
}

/// A name at a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ident {
    /// The spelling.
    pub name: String,
    /// Where.
    pub span: Span,
}

/// The spelling of a type, without array length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TypeName {
    /// `int`
    Int,
    /// `float`
    Float,
    /// `color`
    Color,
    /// `point`
    Point,
    /// `vector`
    Vector,
    /// `normal`
    Normal,
    /// `matrix`
    Matrix,
    /// `string`
    String,
    /// `void`
    Void,
    /// `closure color`
    Closure,
    /// The name of a struct.
    Struct(String),
}

/// A type's spelling and place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypeSpec {
    /// The type.
    pub name: TypeName,
    /// Where.
    pub span: Span,
}

/// The brackets after a declared name.
#[derive(Clone, Debug)]
pub enum ArraySize {
    /// `[]`
    Unsized,
    /// `[expr]`
    Fixed(Expr),
}

/// What stands right of `=` in a declaration.
#[derive(Clone, Debug)]
pub enum Init {
    /// An expression.
    Expr(Expr),
    /// `{ ... }`, possibly nested, possibly empty.
    List(Vec<Init>, Span),
}

/// One `type name = value` of a `[[ ... ]]` block.
#[derive(Clone, Debug)]
pub struct Metadata {
    /// Declared type.
    pub ty: TypeSpec,
    /// Key.
    pub name: Ident,
    /// Brackets after the key.
    pub array: Option<ArraySize>,
    /// The value.
    pub value: Init,
}

/// A shader: `surface name [[meta]] (params) [[meta]] { body }`.
#[derive(Clone, Debug)]
pub struct Shader {
    /// `surface`, `displacement`, `volume` or `shader` as written; checked by [`crate::check`].
    pub kind: Ident,
    /// Its name.
    pub name: Ident,
    /// Both metadata blocks, in order.
    pub metadata: Vec<Metadata>,
    /// Parameters.
    pub params: Vec<Param>,
    /// Body.
    pub body: Block,
    /// From the kind to the closing brace.
    pub span: Span,
}

/// A parameter of a shader or of a function.
#[derive(Clone, Debug)]
pub struct Param {
    /// Declared `output`.
    pub output: bool,
    /// Type.
    pub ty: TypeSpec,
    /// Name.
    pub name: Ident,
    /// Brackets after the name.
    pub array: Option<ArraySize>,
    /// Default (shaders; functions have none).
    pub init: Option<Init>,
    /// Metadata.
    pub metadata: Vec<Metadata>,
}

/// A function; without a body it is a forward declaration.
#[derive(Clone, Debug)]
pub struct Function {
    /// Return type (never an array).
    pub ret: TypeSpec,
    /// Name, `__operator__add__` and the like included.
    pub name: Ident,
    /// Parameters.
    pub params: Vec<Param>,
    /// Metadata after the parameters.
    pub metadata: Vec<Metadata>,
    /// Body.
    pub body: Option<Block>,
    /// The whole declaration.
    pub span: Span,
}

/// `struct Name { type a, b[3]; ... };`
#[derive(Clone, Debug)]
pub struct Struct {
    /// Name.
    pub name: Ident,
    /// Fields, one entry per declared name, in order.
    pub fields: Vec<Field>,
    /// The whole declaration.
    pub span: Span,
}

/// One field.
#[derive(Clone, Debug)]
pub struct Field {
    /// Type.
    pub ty: TypeSpec,
    /// Name.
    pub name: Ident,
    /// Brackets after the name.
    pub array: Option<ArraySize>,
}

/// `{ statements }`; opens a scope.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Statements.
    pub stmts: Vec<Stmt>,
}

/// One declared name of a declaration statement.
#[derive(Clone, Debug)]
pub struct Declarator {
    /// Name.
    pub name: Ident,
    /// Brackets after the name.
    pub array: Option<ArraySize>,
    /// Initial value.
    pub init: Option<Init>,
}

/// A statement with its place.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// Which.
    pub kind: StmtKind,
    /// Where.
    pub span: Span,
}

/// The statements of OSL.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// `;`
    Empty,
    /// `type a, b = 1, c[3] = {..};`
    Declare {
        /// The common type.
        ty: TypeSpec,
        /// The names.
        names: Vec<Declarator>,
    },
    /// A function declared inside a body.
    Function(Box<Function>),
    /// A struct declared inside a body.
    Struct(Box<Struct>),
    /// An expression for its effect.
    Expr(Expr),
    /// `{ ... }`
    Block(Block),
    /// `if (cond) then else otherwise`
    If {
        /// Condition.
        cond: Expr,
        /// Taken when true.
        then: Box<Stmt>,
        /// Taken when false.
        otherwise: Option<Box<Stmt>>,
    },
    /// `while (cond) body`
    While {
        /// Condition.
        cond: Expr,
        /// Body.
        body: Box<Stmt>,
    },
    /// `do body while (cond);`
    DoWhile {
        /// Body.
        body: Box<Stmt>,
        /// Condition.
        cond: Expr,
    },
    /// `for (init; cond; step) body`; names declared in `init` live in the loop.
    For {
        /// A declaration or expression statement, or `Empty`.
        init: Box<Stmt>,
        /// Condition; absent means true.
        cond: Option<Expr>,
        /// Evaluated after each turn.
        step: Option<Expr>,
        /// Body.
        body: Box<Stmt>,
    },
    /// `break;`
    Break,
    /// `continue;`
    Continue,
    /// `return;`, `return expr;`, `return { .. };`
    Return(Option<Init>),
}

/// An expression with its place.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Which.
    pub kind: ExprKind,
    /// Where.
    pub span: Span,
}

/// The expressions of OSL.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// Integer literal; hex up to 0xFFFFFFFF wraps to the same bits.
    Int(i32),
    /// Float literal, at full precision.
    Float(f64),
    /// String literal with escapes resolved and neighbours joined.
    Str(String),
    /// A variable.
    Name(String),
    /// `base[index]`
    Index {
        /// Array, triple or matrix row.
        base: Box<Expr>,
        /// Index.
        index: Box<Expr>,
    },
    /// `base.field`; `.r .g .b .x .y .z` on triples too.
    Field {
        /// Struct or triple.
        base: Box<Expr>,
        /// Field.
        field: Ident,
    },
    /// `f(args)`; also struct constructors, which only `check` can tell apart.
    Call {
        /// Function or struct name.
        callee: Ident,
        /// Arguments; `{..}` lists are allowed.
        args: Vec<Init>,
    },
    /// `color(args)` and the like.
    Construct {
        /// Built-in type.
        ty: TypeSpec,
        /// Arguments.
        args: Vec<Init>,
    },
    /// `(type) expr`
    Cast {
        /// Target.
        ty: TypeSpec,
        /// Operand.
        expr: Box<Expr>,
    },
    /// `- + ! ~`
    Unary {
        /// Operator.
        op: UnaryOp,
        /// Operand.
        expr: Box<Expr>,
    },
    /// `++ --`, before or after.
    IncDec {
        /// Which of the four.
        op: IncDecOp,
        /// An lvalue.
        expr: Box<Expr>,
    },
    /// Two operands.
    Binary {
        /// Operator.
        op: BinaryOp,
        /// Left.
        lhs: Box<Expr>,
        /// Right.
        rhs: Box<Expr>,
    },
    /// `lhs = rhs` (`op` absent) and `lhs op= rhs`.
    Assign {
        /// The operator before `=`.
        op: Option<BinaryOp>,
        /// An lvalue.
        lhs: Box<Expr>,
        /// The value; a list only with plain `=`.
        rhs: Box<Init>,
    },
    /// `cond ? then : otherwise`
    Ternary {
        /// Condition.
        cond: Box<Expr>,
        /// When true.
        then: Box<Expr>,
        /// When false.
        otherwise: Box<Expr>,
    },
    /// `a, b`: evaluates both, is the last.
    Comma(Vec<Expr>),
}

/// Prefix operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOp {
    /// `-`
    Neg,
    /// `+`
    Plus,
    /// `!` and `not`
    Not,
    /// `~`
    Compl,
}

/// Increment and decrement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IncDecOp {
    /// `++x`
    PreInc,
    /// `--x`
    PreDec,
    /// `x++`
    PostInc,
    /// `x--`
    PostDec,
}

/// Infix operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The names are the operators'.
pub enum BinaryOp {
    Mul,
    Div,
    Mod,
    Add,
    Sub,
    Shl,
    Shr,
    Lt,
    Le,
    Gt,
    Ge,
    Eq,
    Ne,
    BitAnd,
    BitXor,
    BitOr,
    And,
    Or,
}

impl BinaryOp {
    /// As written in OSL.
    pub fn symbol(self) -> &'static str {
        use BinaryOp::*;
        match self {
            Mul => "*",
            Div => "/",
            Mod => "%",
            Add => "+",
            Sub => "-",
            Shl => "<<",
            Shr => ">>",
            Lt => "<",
            Le => "<=",
            Gt => ">",
            Ge => ">=",
            Eq => "==",
            Ne => "!=",
            BitAnd => "&",
            BitXor => "^",
            BitOr => "|",
            And => "&&",
            Or => "||",
        }
    }
}
