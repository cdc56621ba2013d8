//! Builds the syntax tree from pest's pairs.
//!
//! The grammar guarantees which children a pair has; where a child is missing all the same, the builder reports a syntax
//! error at the pair instead of panicking.

use super::Rule;
use crate::ast::*;
use crate::diag::Diagnostic;
use crate::escape::unescape;
use crate::preprocess::Preprocessed;
use crate::source::Span;
use pest::iterators::{Pair, Pairs};
use pest::pratt_parser::{Assoc, Op, PrattParser};
use std::sync::LazyLock;

static PRATT: LazyLock<PrattParser<Rule>> = LazyLock::new(|| {
    PrattParser::new()
        .op(Op::infix(Rule::or_op, Assoc::Left))
        .op(Op::infix(Rule::and_op, Assoc::Left))
        .op(Op::infix(Rule::bit_or, Assoc::Left))
        .op(Op::infix(Rule::bit_xor, Assoc::Left))
        .op(Op::infix(Rule::bit_and, Assoc::Left))
        .op(Op::infix(Rule::equality_op, Assoc::Left))
        .op(Op::infix(Rule::relation_op, Assoc::Left))
        .op(Op::infix(Rule::shift_op, Assoc::Left))
        .op(Op::infix(Rule::add_op, Assoc::Left))
        .op(Op::infix(Rule::mul_op, Assoc::Left))
        .op(Op::prefix(Rule::neg)
            | Op::prefix(Rule::plus)
            | Op::prefix(Rule::not)
            | Op::prefix(Rule::compl)
            | Op::prefix(Rule::inc)
            | Op::prefix(Rule::dec)
            | Op::prefix(Rule::cast))
        .op(Op::postfix(Rule::index)
            | Op::postfix(Rule::member)
            | Op::postfix(Rule::post_inc)
            | Op::postfix(Rule::post_dec))
});

type Built<T> = Result<T, Diagnostic>;

pub(super) struct Builder<'a> {
    pre: &'a Preprocessed,
    /// Findings that do not stop the building.
    problems: std::cell::RefCell<Vec<Diagnostic>>,
}

/// Children of a pair that are not mere punctuation.
fn children(pair: Pair<'_, Rule>) -> impl Iterator<Item = Pair<'_, Rule>> {
    pair.into_inner().filter(|p| {
        !matches!(
            p.as_rule(),
            Rule::semi
                | Rule::lparen
                | Rule::rparen
                | Rule::lbrace
                | Rule::rbrace
                | Rule::rbracket
                | Rule::colon
                | Rule::comma
                | Rule::equals
                | Rule::metadata_end
                | Rule::struct_kw
                | Rule::closure_kw
                | Rule::if_kw
                | Rule::else_kw
                | Rule::while_kw
                | Rule::do_kw
                | Rule::for_kw
                | Rule::break_kw
                | Rule::continue_kw
                | Rule::return_kw
                | Rule::EOI
        )
    })
}

impl<'a> Builder<'a> {
    pub fn new(pre: &'a Preprocessed) -> Self {
        Builder { pre, problems: Default::default() }
    }

    fn span(&self, pair: &Pair<'_, Rule>) -> Span {
        let s = pair.as_span();
        self.pre.span(s.start(), s.end())
    }

    fn missing(&self, span: Span) -> Diagnostic {
        Diagnostic::error("E1001", span, "something is missing here")
    }

    /// The tree, and what is wrong in it.
    pub fn file(&self, pair: Pair<'_, Rule>) -> (File, Vec<Diagnostic>) {
        let mut items = Vec::new();
        for child in children(pair) {
            let item = match child.as_rule() {
                Rule::struct_decl => self.structure(child).map(Item::Struct),
                Rule::shader_decl => self.shader(child).map(Item::Shader),
                _ => self.function(child).map(Item::Function),
            };
            match item {
                Ok(item) => items.push(item),
                Err(d) => self.problems.borrow_mut().push(d),
            }
        }
        let (problems, warnings) = self.problems.take().into_iter().partition(Diagnostic::is_error);
        (File { items, warnings, broken: Vec::new() }, problems)
    }

    fn ident(&self, pair: &Pair<'_, Rule>) -> Ident {
        Ident { name: pair.as_str().to_string(), span: self.span(pair) }
    }

    fn shader(&self, pair: Pair<'_, Rule>) -> Built<Shader> {
        let span = self.span(&pair);
        let mut inner = children(pair);
        let kind = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
        let name = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
        let mut shader = Shader { kind, name, metadata: Vec::new(), params: Vec::new(), body: Block::default(), span };
        for child in inner {
            match child.as_rule() {
                Rule::metadata => shader.metadata.extend(self.metadata(child)?),
                Rule::params => shader.params = self.params(child)?,
                _ => shader.body = self.block(child)?,
            }
        }
        Ok(shader)
    }

    fn function(&self, pair: Pair<'_, Rule>) -> Built<Function> {
        let span = self.span(&pair);
        let mut inner = children(pair);
        let ret = self.type_spec(inner.next().ok_or_else(|| self.missing(span))?)?;
        let name = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
        let mut function = Function { ret, name, params: Vec::new(), metadata: Vec::new(), body: None, span };
        for child in inner {
            match child.as_rule() {
                Rule::metadata => function.metadata = self.metadata(child)?,
                Rule::params => function.params = self.params(child)?,
                _ => function.body = Some(self.block(child)?),
            }
        }
        Ok(function)
    }

    fn structure(&self, pair: Pair<'_, Rule>) -> Built<Struct> {
        let span = self.span(&pair);
        let mut inner = children(pair);
        let name = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
        let mut fields = Vec::new();
        for decl in inner {
            let mut parts = children(decl);
            let ty = self.type_spec(parts.next().ok_or_else(|| self.missing(span))?)?;
            for part in parts {
                let mut field = children(part);
                let name = self.ident(&field.next().ok_or_else(|| self.missing(span))?);
                let array = field.next().map(|a| self.array(a)).transpose()?;
                fields.push(Field { ty: ty.clone(), name, array });
            }
        }
        Ok(Struct { name, fields, span })
    }

    fn params(&self, pair: Pair<'_, Rule>) -> Built<Vec<Param>> {
        children(pair).map(|p| self.param(p)).collect()
    }

    fn param(&self, pair: Pair<'_, Rule>) -> Built<Param> {
        let span = self.span(&pair);
        let mut inner = children(pair).peekable();
        let output = inner.next_if(|p| p.as_rule() == Rule::output_kw).is_some();
        let ty = self.type_spec(inner.next().ok_or_else(|| self.missing(span))?)?;
        let name = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
        let mut param = Param { output, ty, name, array: None, init: None, metadata: Vec::new() };
        for child in inner {
            match child.as_rule() {
                Rule::array => param.array = Some(self.array(child)?),
                Rule::metadata => param.metadata = self.metadata(child)?,
                _ => param.init = Some(self.init(child)?),
            }
        }
        Ok(param)
    }

    fn metadata(&self, pair: Pair<'_, Rule>) -> Built<Vec<Metadata>> {
        children(pair)
            .map(|m| {
                let span = self.span(&m);
                let mut inner = children(m).peekable();
                let ty = self.type_spec(inner.next().ok_or_else(|| self.missing(span))?)?;
                let name = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
                let array = match inner.next_if(|p| p.as_rule() == Rule::array) {
                    Some(a) => Some(self.array(a)?),
                    None => None,
                };
                let value = self.init(inner.next().ok_or_else(|| self.missing(span))?)?;
                Ok(Metadata { ty, name, array, value })
            })
            .collect()
    }

    fn array(&self, pair: Pair<'_, Rule>) -> Built<ArraySize> {
        match children(pair).next() {
            Some(expr) => Ok(ArraySize::Fixed(self.expr(expr)?)),
            None => Ok(ArraySize::Unsized),
        }
    }

    fn type_spec(&self, pair: Pair<'_, Rule>) -> Built<TypeSpec> {
        let span = self.span(&pair);
        let inner = match pair.as_rule() {
            Rule::type_spec => children(pair).next().ok_or_else(|| self.missing(span))?,
            _ => pair,
        };
        let name = match (inner.as_rule(), inner.as_str()) {
            (Rule::ident, name) => TypeName::Struct(name.to_string()),
            (Rule::closure_type, _) => {
                // `closure matrix` and the like are read as in the reference: closures of any type add up alike.
                TypeName::Closure
            }
            (_, "int") => TypeName::Int,
            (_, "float") => TypeName::Float,
            (_, "color") => TypeName::Color,
            (_, "point") => TypeName::Point,
            (_, "vector") => TypeName::Vector,
            (_, "normal") => TypeName::Normal,
            (_, "matrix") => TypeName::Matrix,
            (_, "string") => TypeName::String,
            _ => TypeName::Void,
        };
        Ok(TypeSpec { name, span })
    }

    fn init(&self, pair: Pair<'_, Rule>) -> Built<Init> {
        match pair.as_rule() {
            Rule::init_list => {
                let span = self.span(&pair);
                let items = children(pair).map(|p| self.init(p)).collect::<Built<Vec<_>>>()?;
                Ok(Init::List(items, span))
            }
            _ => Ok(Init::Expr(self.expr(pair)?)),
        }
    }

    fn block(&self, pair: Pair<'_, Rule>) -> Built<Block> {
        let mut stmts = Vec::new();
        for child in children(pair) {
            // A finding in one statement does not hide those in the next.
            match self.stmt(child) {
                Ok(stmt) => stmts.push(stmt),
                Err(d) => self.problems.borrow_mut().push(d),
            }
        }
        Ok(Block { stmts })
    }

    fn stmt(&self, pair: Pair<'_, Rule>) -> Built<Stmt> {
        let span = self.span(&pair);
        let rule = pair.as_rule();
        if rule == Rule::block {
            return Ok(Stmt { kind: StmtKind::Block(self.block(pair)?), span });
        }
        if rule == Rule::struct_decl {
            return Ok(Stmt { kind: StmtKind::Struct(Box::new(self.structure(pair)?)), span });
        }
        if rule == Rule::function_decl {
            return Ok(Stmt { kind: StmtKind::Function(Box::new(self.function(pair)?)), span });
        }
        let mut inner = children(pair);
        let mut next = || inner.next().ok_or_else(|| self.missing(span));
        let kind = match rule {
            Rule::if_stmt => {
                let cond = self.expr(next()?)?;
                let then = Box::new(self.stmt(next()?)?);
                let otherwise = match next() {
                    Ok(p) => Some(Box::new(self.stmt(p)?)),
                    Err(_) => None,
                };
                StmtKind::If { cond, then, otherwise }
            }
            Rule::while_stmt => StmtKind::While { cond: self.expr(next()?)?, body: Box::new(self.stmt(next()?)?) },
            Rule::do_stmt => StmtKind::DoWhile { body: Box::new(self.stmt(next()?)?), cond: self.expr(next()?)? },
            Rule::for_stmt => {
                let init = Box::new(self.stmt(next()?)?);
                let cond = children(next()?).next().map(|e| self.expr(e)).transpose()?;
                let step = children(next()?).next().map(|e| self.expr(e)).transpose()?;
                StmtKind::For { init, cond, step, body: Box::new(self.stmt(next()?)?) }
            }
            Rule::break_stmt => StmtKind::Break,
            Rule::continue_stmt => StmtKind::Continue,
            Rule::return_stmt => StmtKind::Return(inner.next().map(|p| self.init(p)).transpose()?),
            Rule::declaration => {
                let ty = self.type_spec(next()?)?;
                let names = inner.map(|p| self.declarator(p)).collect::<Built<Vec<_>>>()?;
                StmtKind::Declare { ty, names }
            }
            Rule::empty_stmt => StmtKind::Empty,
            _ => StmtKind::Expr(self.expr(next()?)?),
        };
        Ok(Stmt { kind, span })
    }

    fn declarator(&self, pair: Pair<'_, Rule>) -> Built<Declarator> {
        let span = self.span(&pair);
        let mut inner = children(pair);
        let name = self.ident(&inner.next().ok_or_else(|| self.missing(span))?);
        let mut declarator = Declarator { name, array: None, init: None };
        for child in inner {
            match child.as_rule() {
                Rule::array => declarator.array = Some(self.array(child)?),
                _ => declarator.init = Some(self.init(child)?),
            }
        }
        Ok(declarator)
    }

    /// `expr` (with commas), `assign` or `chain`.
    fn expr(&self, pair: Pair<'_, Rule>) -> Built<Expr> {
        let span = self.span(&pair);
        match pair.as_rule() {
            Rule::expr => {
                let mut parts = children(pair).map(|p| self.expr(p)).collect::<Built<Vec<_>>>()?;
                match parts.len() {
                    1 => parts.pop().ok_or_else(|| self.missing(span)),
                    _ => Ok(Expr { kind: ExprKind::Comma(parts), span }),
                }
            }
            Rule::assign => self.assign(pair),
            _ => self.chain(pair.into_inner()),
        }
    }

    fn assign(&self, pair: Pair<'_, Rule>) -> Built<Expr> {
        let span = self.span(&pair);
        let mut inner = children(pair).peekable();
        let mut expr = self.expr(inner.next().ok_or_else(|| self.missing(span))?)?;
        if inner.peek().is_some_and(|p| p.as_rule() == Rule::assign) {
            let then = Box::new(self.expr(inner.next().ok_or_else(|| self.missing(span))?)?);
            let otherwise = Box::new(self.expr(inner.next().ok_or_else(|| self.missing(span))?)?);
            let whole = expr.span.to(otherwise.span);
            expr = Expr { kind: ExprKind::Ternary { cond: Box::new(expr), then, otherwise }, span: whole };
        }
        let Some(op) = inner.next() else { return Ok(expr) };
        let op = match op.as_str() {
            "=" => None,
            compound => infix(compound.trim_end_matches('=')),
        };
        let rhs = Box::new(self.init(inner.next().ok_or_else(|| self.missing(span))?)?);
        Ok(Expr { kind: ExprKind::Assign { op, lhs: Box::new(expr), rhs }, span })
    }

    fn chain(&self, pairs: Pairs<'_, Rule>) -> Built<Expr> {
        PRATT
            .map_primary(|p| self.primary(p))
            .map_prefix(|op, rhs| {
                let rhs = rhs?;
                let span = self.span(&op).to(rhs.span);
                let expr = Box::new(rhs);
                let kind = match op.as_rule() {
                    Rule::neg => ExprKind::Unary { op: UnaryOp::Neg, expr },
                    Rule::plus => ExprKind::Unary { op: UnaryOp::Plus, expr },
                    Rule::not => ExprKind::Unary { op: UnaryOp::Not, expr },
                    Rule::compl => ExprKind::Unary { op: UnaryOp::Compl, expr },
                    Rule::inc => ExprKind::IncDec { op: IncDecOp::PreInc, expr },
                    Rule::dec => ExprKind::IncDec { op: IncDecOp::PreDec, expr },
                    _ => {
                        let ty = op.into_inner().next().ok_or_else(|| self.missing(span))?;
                        ExprKind::Cast { ty: self.type_spec(ty)?, expr }
                    }
                };
                Ok(Expr { kind, span })
            })
            .map_postfix(|lhs, op| {
                let lhs = lhs?;
                let span = lhs.span.to(self.span(&op));
                let base = Box::new(lhs);
                let kind = match op.as_rule() {
                    Rule::post_inc => ExprKind::IncDec { op: IncDecOp::PostInc, expr: base },
                    Rule::post_dec => ExprKind::IncDec { op: IncDecOp::PostDec, expr: base },
                    Rule::member => {
                        let field = op.into_inner().next().ok_or_else(|| self.missing(span))?;
                        ExprKind::Field { base, field: self.ident(&field) }
                    }
                    _ => {
                        let index = children(op).next().ok_or_else(|| self.missing(span))?;
                        ExprKind::Index { base, index: Box::new(self.expr(index)?) }
                    }
                };
                Ok(Expr { kind, span })
            })
            .map_infix(|lhs, op, rhs| {
                let (lhs, rhs) = (lhs?, rhs?);
                let span = lhs.span.to(rhs.span);
                let op = infix(op.as_str()).ok_or_else(|| self.missing(span))?;
                Ok(Expr { kind: ExprKind::Binary { op, lhs: Box::new(lhs), rhs: Box::new(rhs) }, span })
            })
            .parse(pairs)
    }

    fn primary(&self, pair: Pair<'_, Rule>) -> Built<Expr> {
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::int_lit => ExprKind::Int(self.int(pair.as_str(), span)),
            Rule::float_lit => ExprKind::Float(pair.as_str().parse().unwrap_or(f64::INFINITY)),
            Rule::strings => {
                let parts = pair.into_inner().map(|p| self.string(&p));
                ExprKind::Str(parts.collect::<String>())
            }
            Rule::ident => ExprKind::Name(pair.as_str().to_string()),
            Rule::bracketed => {
                let inner = children(pair).next().ok_or_else(|| self.missing(span))?;
                let e = self.expr(inner)?;
                if matches!(e.kind, ExprKind::Comma(_)) {
                    // `color c = (1, 0, 0)` is what other languages mean by a color.
                    let d = Diagnostic::warning("W1001", span, "only the last of these values counts")
                        .help("a triple is written with its type: `color(1, 0, 0)`");
                    self.problems.borrow_mut().push(d);
                }
                return Ok(Expr { span, ..e });
            }
            rule => {
                let mut inner = children(pair);
                let head = inner.next().ok_or_else(|| self.missing(span))?;
                let args = match inner.next() {
                    Some(args) => children(args).map(|a| self.init(a)).collect::<Built<Vec<_>>>()?,
                    None => Vec::new(),
                };
                match rule {
                    Rule::construct => ExprKind::Construct { ty: self.type_spec(head)?, args },
                    _ => ExprKind::Call { callee: self.ident(&head), args },
                }
            }
        };
        Ok(Expr { kind, span })
    }

    /// Decimal up to 2147483648 (so that its negation can be written), hex up to 0xFFFFFFFF; both wrap to 32 bits.
    fn int(&self, text: &str, span: Span) -> i32 {
        let parsed = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
            Some(hex) => u64::from_str_radix(hex, 16).ok().filter(|v| *v <= u32::MAX as u64),
            None => text.parse::<u64>().ok().filter(|v| *v <= 1 << 31),
        };
        parsed.map_or_else(
            || {
                let message = format!("`{text}` does not fit a 32-bit int");
                self.problems.borrow_mut().push(Diagnostic::error("E1003", span, message));
                0
            },
            |v| v as u32 as i32,
        )
    }

    /// Resolves C escapes; an unknown escape stands for the character itself.
    fn string(&self, pair: &Pair<'_, Rule>) -> String {
        let text = pair.as_str();
        unescape(&text[1..text.len() - 1])
    }
}

fn infix(text: &str) -> Option<BinaryOp> {
    Some(match text {
        "*" => BinaryOp::Mul,
        "/" => BinaryOp::Div,
        "%" => BinaryOp::Mod,
        "+" => BinaryOp::Add,
        "-" => BinaryOp::Sub,
        "<<" => BinaryOp::Shl,
        ">>" => BinaryOp::Shr,
        "<" => BinaryOp::Lt,
        "<=" => BinaryOp::Le,
        ">" => BinaryOp::Gt,
        ">=" => BinaryOp::Ge,
        "==" => BinaryOp::Eq,
        "!=" => BinaryOp::Ne,
        "&" => BinaryOp::BitAnd,
        "^" => BinaryOp::BitXor,
        "|" => BinaryOp::BitOr,
        "&&" | "and" => BinaryOp::And,
        "||" | "or" => BinaryOp::Or,
        _ => return None,
    })
}
