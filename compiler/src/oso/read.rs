//! [`Module`] to the typed tree, on which the same lowering of built-ins goes on as from OSL.
//!
//! In: a module. Out: [`Checked`], or located errors. Structs stay the symbols of their fields; branches and loops become
//! statements again; an inlined function is a function without parameters that is called where it stood; a parameter's code
//! section is a function that returns its default. It must not know the IR or any target.

use super::read_call::{binary_op, literal_value, meta};
use super::{Element, Literal, MAIN, Module, Op, SymId, Symbol, SymbolKind};
use crate::ast::BinaryOp;
use crate::builtins;
use crate::check::typed::{
    Callee, Expr, ExprKind, Function, FunctionId, Param, Shader, Stmt, Struct, Var, VarId, VarKind, VendorClosure,
};
use crate::check::{Checked, GLOBALS};
use crate::diag::Diagnostic;
use crate::reflect::{self, ShaderInfo, Value};
use crate::source::Span;
use crate::types::{Base, Extent, StructId, Traits, Type};
use std::collections::HashMap;

/// Deepest nesting of branches, loops and inlined functions.
const MAX_NESTING: usize = 1_000;

/// Makes the typed tree of a module.
pub fn read(module: &Module) -> Result<Checked, Vec<Diagnostic>> {
    let mut reader = Reader {
        module,
        vars: Vec::new(),
        var_of: vec![None; module.symbols.len()],
        functions: Vec::new(),
        body: Body::Main,
        nesting: 0,
        loops: 0,
        errors: Vec::new(),
    };
    reader.variables();
    let (params, infos, structs) = reader.params();
    let main = module.sections.iter().position(|(name, _)| name == MAIN);
    let body = main.map_or(Vec::new(), |index| reader.block(module.section(index)));
    let errors = reader.errors;
    if !errors.is_empty() {
        return Err(errors);
    }
    let metadata = module.hints.iter().filter_map(meta).collect();
    let (name, kind) = (module.name.clone(), module.kind.clone());
    let info = ShaderInfo { name: name.clone(), kind: kind.clone(), metadata, params: infos };
    let (vars, functions) = (reader.vars, reader.functions);
    let shader = Shader { name, kind, params, body, vars, structs, functions };
    Ok(Checked { shader, info, warnings: Vec::new() })
}

/// What `return` leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    /// The shader.
    Main,
    /// The code of a parameter's default.
    Default(VarId),
    /// An inlined function.
    Function,
}

pub(super) struct Reader<'m> {
    pub module: &'m Module,
    vars: Vec<Var>,
    var_of: Vec<Option<VarId>>,
    functions: Vec<Function>,
    body: Body,
    nesting: usize,
    loops: u32,
    pub errors: Vec<Diagnostic>,
}

/// Says why an operation is refused.
pub(super) type Fit<T> = Result<T, Diagnostic>;

/// An error about an operation.
pub(super) fn unfit(op: &Op, message: impl std::fmt::Display) -> Diagnostic {
    Diagnostic::error("E5002", op.span, format!("operation `{}` {message}", op.name))
}

impl<'m> Reader<'m> {
    fn error(&mut self, d: Diagnostic) {
        if self.errors.len() < 20 {
            self.errors.push(d);
        }
    }

    /// The type of a symbol. An unsized array has the length of its default.
    pub fn ty(&self, symbol: &Symbol) -> Type {
        let base = symbol.ty.base().unwrap_or(Base::Void);
        let extent = match symbol.ty.extent {
            Extent::Unsized => Extent::Fixed((symbol.values.len() / symbol.ty.components()).max(1) as u32),
            extent => extent,
        };
        Type { base, extent }
    }

    /// A variable for each symbol that is neither a constant nor a struct.
    fn variables(&mut self) {
        let mut params = 0;
        for (i, symbol) in self.module.symbols.iter().enumerate() {
            if symbol.kind == SymbolKind::Const || symbol.ty.base().is_none() {
                continue;
            }
            let ty = self.ty(symbol);
            let kind = match symbol.kind {
                SymbolKind::Param | SymbolKind::OutputParam => {
                    params += 1;
                    VarKind::ShaderParam(params - 1)
                }
                SymbolKind::Global => {
                    if !GLOBALS.iter().any(|(name, base, _)| *name == symbol.name && ty == Type::scalar(*base)) {
                        let message = format!("there is no shader global `{} {}`", symbol.ty.spelling(), symbol.name);
                        self.error(Diagnostic::error("E5001", symbol.span, message));
                    }
                    VarKind::Global
                }
                _ => VarKind::Local,
            };
            if ty.base == Base::Void {
                let message = format!("symbol `{}` cannot be void", symbol.name);
                self.error(Diagnostic::error("E5001", symbol.span, message));
            }
            // `___12_name` is the format's way to tell the variables of scopes apart.
            let plain = symbol.name.strip_prefix("___").and_then(|n| n.split_once('_'));
            let name = plain.map_or(symbol.name.as_str(), |(_, name)| name).replace('$', "");
            self.var_of[i] = Some(VarId(self.vars.len() as u32));
            self.vars.push(Var { name, ty, kind, writable: true, span: symbol.span });
        }
    }

    fn params(&mut self) -> (Vec<Param>, Vec<reflect::Param>, Vec<Struct>) {
        let (mut params, mut infos, mut structs) = (Vec::new(), Vec::new(), Vec::new());
        // The struct parameter whose fields are being read.
        let mut inside: Option<String> = None;
        let (mut varying, mut traits) = (false, Traits::default());
        for (i, symbol) in self.module.symbols.iter().enumerate() {
            if !symbol.kind.is_param() {
                continue;
            }
            let field = inside.as_ref().and_then(|root| symbol.name.strip_prefix(root.as_str())?.strip_prefix('.'));
            let field = field.filter(|_| symbol.hint("mystruct").is_some()).map(str::to_owned);
            let metadata: Vec<reflect::Metadata> = symbol.hints.iter().filter_map(meta).collect();
            let output = symbol.kind == SymbolKind::OutputParam;
            if field.is_none() {
                inside = None;
                (varying, traits) = reflect::hints(&metadata, false);
            }
            let Some(var) = self.var_of[i] else {
                if let (Element::Struct(name), None) = (&symbol.ty.element, &field) {
                    inside = Some(symbol.name.clone());
                    let id = StructId(structs.len() as u32);
                    structs.push(Struct { name: name.clone(), fields: Vec::new() });
                    infos.push(reflect::Param {
                        name: symbol.name.clone(),
                        ty: symbol.ty.spelling().trim_start_matches("struct ").to_owned(),
                        resolved: Type { base: Base::Struct(id), extent: symbol.ty.extent },
                        output,
                        default: None,
                        fields: Vec::new(),
                        metadata,
                    });
                }
                continue;
            };
            let init = self.default_of(symbol, var);
            if let (Some(field), Some(info)) = (&field, infos.last_mut()) {
                info.fields.push(reflect::Field { name: field.clone(), ty: symbol.ty.spelling() });
                if let Some(s) = structs.last_mut() {
                    s.fields.push((field.clone(), self.ty(symbol)));
                }
            } else {
                let computed = matches!(&init, Some(e) if matches!(e.kind, ExprKind::Call(..)));
                infos.push(reflect::Param {
                    name: symbol.name.clone(),
                    ty: symbol.ty.spelling(),
                    resolved: self.ty(symbol),
                    output,
                    default: if computed { None } else { literal_value(symbol) },
                    fields: Vec::new(),
                    metadata,
                });
            }
            let traits = Traits { open: symbol.ty.extent == Extent::Unsized, ..traits };
            params.push(Param { var, output, init, varying, traits });
        }
        let symbols: HashMap<&str, &Symbol> = self.module.symbols.iter().map(|s| (s.name.as_str(), s)).collect();
        for info in infos.iter_mut().filter(|i| !i.fields.is_empty()) {
            info.default = self.struct_default(&info.name, &symbols, 0);
        }
        (params, infos, structs)
    }

    /// The defaults of a struct's fields, when all are values.
    fn struct_default(&self, name: &str, symbols: &HashMap<&str, &Symbol>, depth: usize) -> Option<Value> {
        let symbol = symbols.get(name)?;
        let Element::Struct(_) = symbol.ty.element else {
            let computed = self.module.sections.iter().any(|(n, _)| n == name);
            return literal_value(symbol).filter(|_| !computed);
        };
        if depth > MAX_NESTING {
            return None;
        }
        let names = &symbol.hint("structfields")?.args;
        let fields = names.iter().map(|f| self.struct_default(&format!("{name}.{}", f.text()), symbols, depth + 1));
        let fields: Vec<Value> = fields.collect::<Option<_>>()?;
        let Extent::Fixed(n) = symbol.ty.extent else { return Some(Value::List(fields)) };
        // Of an array of structs, each field is an array: turned round, an array of structs again.
        let element = |i: usize| {
            let part = |field: &Value| match field {
                Value::List(items) => items.get(i).cloned(),
                _ => None,
            };
            fields.iter().map(part).collect::<Option<Vec<_>>>().map(Value::List)
        };
        let shortest = fields.iter().map(|f| if let Value::List(l) = f { l.len() } else { 0 }).min().unwrap_or(0);
        (0..shortest.min(n as usize)).map(element).collect::<Option<Vec<_>>>().map(Value::List)
    }

    /// A parameter's default: its values, or a call of what its code section becomes.
    fn default_of(&mut self, symbol: &Symbol, var: VarId) -> Option<Expr> {
        let section = self.module.sections.iter().position(|(name, _)| *name == symbol.name);
        let ty = self.ty(symbol);
        let Some(section) = section else { return self.literal(symbol) };
        let range = self.module.section(section);
        self.body = Body::Default(var);
        let mut body = self.block(range);
        self.body = Body::Main;
        let result = Expr { kind: ExprKind::Var(var), ty, span: symbol.span };
        body.push(Stmt::Return(Some(result), symbol.span));
        let id = self.function(symbol.name.clone(), ty, body, symbol.span);
        Some(Expr { kind: ExprKind::Call(Callee::User(id), Vec::new()), ty, span: symbol.span })
    }

    fn function(&mut self, name: String, ret: Type, body: Vec<Stmt>, span: Span) -> FunctionId {
        self.functions.push(Function {
            name,
            ret,
            params: Vec::new(),
            body: Some(body),
            closure: VendorClosure::No,
            span,
        });
        FunctionId(self.functions.len() as u32 - 1)
    }

    /// A closure of another renderer.
    pub(super) fn vendor_closure(&mut self, name: String, span: Span) -> FunctionId {
        self.functions.push(Function {
            name,
            ret: Type::scalar(Base::Closure),
            params: Vec::new(),
            body: None,
            closure: VendorClosure::Unknown,
            span,
        });
        FunctionId(self.functions.len() as u32 - 1)
    }

    /// The value that a symbol's line tells; `None` when it tells none.
    fn literal(&self, symbol: &Symbol) -> Option<Expr> {
        let (ty, span) = (self.ty(symbol), symbol.span);
        if ty.base == Base::Closure {
            let zero = Box::new(Expr { kind: ExprKind::Int(0), ty: Type::INT, span });
            return (!ty.is_array()).then_some(Expr { kind: ExprKind::Convert(zero), ty, span });
        }
        let one = |v: &Literal| match (v, ty.base) {
            (Literal::Int(v), Base::Int) => Expr { kind: ExprKind::Int(*v), ty: Type::INT, span },
            (Literal::Int(v), _) => Expr { kind: ExprKind::Float(f64::from(*v)), ty: Type::FLOAT, span },
            (Literal::Float(v), _) => Expr { kind: ExprKind::Float(*v), ty: Type::FLOAT, span },
            (Literal::Str(s), _) => Expr { kind: ExprKind::Str(s.clone()), ty: Type::STRING, span },
        };
        let n = symbol.ty.components();
        let element = Type::scalar(ty.base);
        // What is missing of a last triple or matrix is 0.
        let mut elements = symbol.values.chunks(n).map(|chunk| {
            let mut parts: Vec<Expr> = chunk.iter().map(one).collect();
            if n == 1 {
                return parts.remove(0);
            }
            parts.resize(n, Expr { kind: ExprKind::Float(0.0), ty: Type::FLOAT, span });
            Expr { kind: ExprKind::Construct(parts), ty: element, span }
        });
        if !ty.is_array() {
            return elements.next();
        }
        let list: Vec<Expr> = elements.collect();
        (!list.is_empty()).then_some(Expr { kind: ExprKind::List(list), ty, span })
    }

    /// A symbol as an expression.
    pub fn get(&self, op: &Op, id: SymId) -> Fit<Expr> {
        let symbol = self.module.symbol(id);
        if symbol.kind == SymbolKind::Const {
            let constant = self.literal(symbol).map(|e| Expr { span: op.span, ..e });
            return constant
                .ok_or_else(|| unfit(op, format!("takes the constant `{}`, which has no value", symbol.name)));
        }
        match self.var_of[id.0 as usize] {
            Some(var) => Ok(Expr { kind: ExprKind::Var(var), ty: self.ty(symbol), span: op.span }),
            None => Err(unfit(op, format!("takes the struct `{}` as a whole", symbol.name))),
        }
    }

    /// The argument with this index.
    pub fn arg(&self, op: &Op, index: usize) -> Fit<Expr> {
        match op.args.get(index) {
            Some(id) => self.get(op, *id),
            None => Err(unfit(op, format!("needs more than {} arguments", op.args.len()))),
        }
    }

    /// The argument that is written.
    pub fn target(&self, op: &Op, index: usize) -> Fit<Expr> {
        let e = self.arg(op, index)?;
        match e.kind {
            ExprKind::Var(_) => Ok(e),
            _ => Err(unfit(op, "writes to a constant")),
        }
    }

    /// The string constant that argument `index` is.
    pub fn constant_string(&self, op: &Op, index: usize) -> Fit<String> {
        match self.arg(op, index)?.kind {
            ExprKind::Str(s) => Ok(s),
            _ => Err(unfit(op, "needs a constant string")),
        }
    }

    fn jump(&self, op: &Op, index: usize, from: usize, end: usize) -> Fit<usize> {
        match op.jumps.get(index).map(|j| *j as usize) {
            Some(j) if (from..=end).contains(&j) => Ok(j),
            Some(_) => Err(unfit(op, "jumps out of the block that it stands in")),
            None => Err(unfit(op, "lacks a jump target")),
        }
    }

    /// The statements of a range of operations.
    pub fn block(&mut self, range: std::ops::Range<usize>) -> Vec<Stmt> {
        let mut out = Vec::new();
        if self.nesting >= MAX_NESTING {
            if let Some(op) = self.module.ops.get(range.start) {
                let d = unfit(op, format!("nests deeper than {MAX_NESTING} branches, loops and functions"));
                self.error(d);
            }
            return out;
        }
        self.nesting += 1;
        let mut at = range.start;
        while at < range.end && self.errors.len() < 20 {
            let module = self.module;
            let op = &module.ops[at];
            match self.statement(op, at, range.end, &mut out) {
                Ok(next) => at = next,
                Err(d) => {
                    self.error(d);
                    at += 1;
                }
            }
        }
        self.nesting -= 1;
        out
    }

    /// One operation with what belongs to it; the number of the next.
    fn statement(&mut self, op: &Op, at: usize, end: usize, out: &mut Vec<Stmt>) -> Fit<usize> {
        match op.name.as_str() {
            "end" => return Ok(end),
            "nop" | "useparam" => {}
            "if" => {
                let cond = truth(op, self.arg(op, 0)?)?;
                let middle = self.jump(op, 0, at + 1, end)?;
                let after = self.jump(op, 1, middle, end)?;
                let then = self.block(at + 1..middle);
                let otherwise = self.block(middle..after);
                out.push(Stmt::If(cond, then, otherwise));
                return Ok(after);
            }
            "functioncall" | "functioncall_nr" => {
                let name = self.constant_string(op, 0)?;
                let after = self.jump(op, 0, at + 1, end)?;
                let (outer, loops) = (self.body, self.loops);
                (self.body, self.loops) = (Body::Function, 0);
                let body = self.block(at + 1..after);
                (self.body, self.loops) = (outer, loops);
                let id = self.function(name, Type::VOID, body, op.span);
                let kind = ExprKind::Call(Callee::User(id), Vec::new());
                out.push(Stmt::Expr(Expr { kind, ty: Type::VOID, span: op.span }));
                return Ok(after);
            }
            "for" | "while" | "dowhile" => return self.loop_(op, at, end, out),
            "break" | "continue" => {
                if self.loops == 0 {
                    return Err(unfit(op, "stands outside of a loop"));
                }
                out.push(if op.name == "break" { Stmt::Break } else { Stmt::Continue });
            }
            "return" | "exit" => out.push(self.leave(op)),
            _ => {
                let e = self.operation(op)?;
                out.push(Stmt::Expr(e));
            }
        }
        Ok(at + 1)
    }

    fn leave(&self, op: &Op) -> Stmt {
        match self.body {
            Body::Default(var) => {
                let ty = self.vars[var.0 as usize].ty;
                Stmt::Return(Some(Expr { kind: ExprKind::Var(var), ty, span: op.span }), op.span)
            }
            Body::Function if op.name == "exit" => {
                let (kind, ty) = match builtins::find("exit") {
                    Some(id) => {
                        let callee = Callee::Builtin { id, formals: Vec::new(), outputs: Vec::new() };
                        (ExprKind::Call(callee, Vec::new()), Type::VOID)
                    }
                    None => (ExprKind::Comma(Vec::new()), Type::VOID),
                };
                Stmt::Expr(Expr { kind, ty, span: op.span })
            }
            _ => Stmt::Return(None, op.span),
        }
    }

    fn loop_(&mut self, op: &Op, at: usize, end: usize, out: &mut Vec<Stmt>) -> Fit<usize> {
        let start = self.jump(op, 0, at + 1, end)?;
        let first = self.jump(op, 1, start, end)?;
        let iteration = self.jump(op, 2, first, end)?;
        let after = self.jump(op, 3, iteration, end)?;
        let init = self.block(at + 1..start);
        out.extend(init);
        let cond = self.block(start..first);
        let cond = self.condition(op, cond)?;
        self.loops += 1;
        let body = self.block(first..iteration);
        self.loops -= 1;
        let step = self.block(iteration..after);
        let step = match simple(step) {
            Ok(parts) if parts.is_empty() => None,
            Ok(parts) => Some(comma(parts, op.span)),
            Err(body) => {
                let id = self.function("step".to_owned(), Type::VOID, body, op.span);
                Some(Expr { kind: ExprKind::Call(Callee::User(id), Vec::new()), ty: Type::VOID, span: op.span })
            }
        };
        out.push(Stmt::Loop { cond: Some(cond), after: op.name == "dowhile", step, body });
        Ok(after)
    }

    /// The code of a loop's condition as one expression.
    fn condition(&mut self, op: &Op, code: Vec<Stmt>) -> Fit<Expr> {
        let read = self.arg(op, 0)?;
        match simple(code) {
            Ok(mut parts) => {
                // Mostly the last operation computes just the condition.
                let computed = parts.last().is_some_and(
                    |e| matches!(&e.kind, ExprKind::Assign(to, _) if to.kind_is_var_of(&read) && e.ty == read.ty),
                );
                if !computed {
                    parts.push(read);
                }
                truth(op, comma(parts, op.span))
            }
            Err(mut body) => {
                let ty = Type::INT;
                body.push(Stmt::Return(Some(truth(op, read)?), op.span));
                let id = self.function("condition".to_owned(), ty, body, op.span);
                Ok(Expr { kind: ExprKind::Call(Callee::User(id), Vec::new()), ty, span: op.span })
            }
        }
    }

    /// An operation that is no control flow.
    fn operation(&mut self, op: &Op) -> Fit<Expr> {
        let assign = |to: Expr, value: Expr| -> Fit<Expr> {
            let value = fitted(op, value, to.ty)?;
            let (ty, span) = (to.ty, op.span);
            Ok(Expr { kind: ExprKind::Assign(Box::new(to), Box::new(value)), ty, span })
        };
        let node = |kind: ExprKind, ty: Type| Expr { kind, ty, span: op.span };
        let index = |e: Expr| if e.ty == Type::INT { Ok(Box::new(e)) } else { Err(unfit(op, "needs an int as index")) };
        match op.name.as_str() {
            "assign" | "arraycopy" => assign(self.target(op, 0)?, self.arg(op, 1)?),
            "aref" => {
                let array = array(op, self.arg(op, 1)?)?;
                let ty = Type::scalar(array.ty.base);
                let value = node(ExprKind::Index(Box::new(array), index(self.arg(op, 2)?)?), ty);
                assign(self.target(op, 0)?, value)
            }
            "aassign" => {
                let array = array(op, self.target(op, 0)?)?;
                let ty = Type::scalar(array.ty.base);
                let to = node(ExprKind::Index(Box::new(array), index(self.arg(op, 1)?)?), ty);
                assign(to, self.arg(op, 2)?)
            }
            "compref" => {
                let triple = triple(op, self.arg(op, 1)?)?;
                let value = node(ExprKind::Component(Box::new(triple), index(self.arg(op, 2)?)?), Type::FLOAT);
                assign(self.target(op, 0)?, value)
            }
            "compassign" => {
                let triple = triple(op, self.target(op, 0)?)?;
                let to = node(ExprKind::Component(Box::new(triple), index(self.arg(op, 1)?)?), Type::FLOAT);
                assign(to, self.arg(op, 2)?)
            }
            "mxcompref" => {
                let matrix = matrix(op, self.arg(op, 1)?)?;
                let (row, column) = (index(self.arg(op, 2)?)?, index(self.arg(op, 3)?)?);
                let value = node(ExprKind::Element(Box::new(matrix), row, column), Type::FLOAT);
                assign(self.target(op, 0)?, value)
            }
            "mxcompassign" => {
                let matrix = matrix(op, self.target(op, 0)?)?;
                let (row, column) = (index(self.arg(op, 1)?)?, index(self.arg(op, 2)?)?);
                let to = node(ExprKind::Element(Box::new(matrix), row, column), Type::FLOAT);
                assign(to, self.arg(op, 3)?)
            }
            "neg" | "compl" => {
                let value = single(op, self.arg(op, 1)?)?;
                let ty = value.ty;
                let fits = if op.name == "neg" { ty.base != Base::String } else { ty == Type::INT };
                if !fits {
                    return Err(unfit(op, format!("does not take {}", ty.base.keyword())));
                }
                let value = Box::new(value);
                let kind = if op.name == "neg" { ExprKind::Neg(value) } else { ExprKind::Compl(value) };
                assign(self.target(op, 0)?, node(kind, ty))
            }
            "color" | "point" | "vector" | "normal" | "matrix" => self.construct(op),
            "closure" => {
                let value = self.closure(op)?;
                assign(self.target(op, 0)?, value)
            }
            name => match binary_op(name) {
                // Of floats, `mod` is what the function `fmod` is.
                Some(BinaryOp::Mod) if self.arg(op, 0)?.ty != Type::INT => self.builtin(op),
                Some(operator) if op.args.len() == 3 => {
                    let value = self.binary(op, operator)?;
                    assign(self.target(op, 0)?, value)
                }
                Some(_) => Err(unfit(op, "needs a result and two operands")),
                None => self.builtin(op),
            },
        }
    }
}

impl Expr {
    /// Whether both are the same variable.
    fn kind_is_var_of(&self, other: &Expr) -> bool {
        matches!((&self.kind, &other.kind), (ExprKind::Var(a), ExprKind::Var(b)) if a == b)
    }
}

/// Statements that are expressions only, or the statements.
fn simple(stmts: Vec<Stmt>) -> Result<Vec<Expr>, Vec<Stmt>> {
    if stmts.iter().all(|s| matches!(s, Stmt::Expr(_))) {
        let expr = |s| match s {
            Stmt::Expr(e) => Some(e),
            _ => None,
        };
        return Ok(stmts.into_iter().filter_map(expr).collect());
    }
    Err(stmts)
}

fn comma(mut parts: Vec<Expr>, span: Span) -> Expr {
    match parts.len() {
        1 => parts.remove(0),
        _ => {
            let ty = parts.last().map_or(Type::VOID, |e| e.ty);
            Expr { kind: ExprKind::Comma(parts), ty, span }
        }
    }
}

fn array(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty.is_array() { Ok(e) } else { Err(unfit(op, "needs an array")) }
}

fn triple(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty.base.is_triple() && !e.ty.is_array() {
        Ok(e)
    } else {
        Err(unfit(op, "needs a color, point, vector or normal"))
    }
}

fn matrix(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty == Type::scalar(Base::Matrix) { Ok(e) } else { Err(unfit(op, "needs a matrix")) }
}

/// An operand that is no array.
pub(super) fn single(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty.is_array() { Err(unfit(op, "does not take arrays")) } else { Ok(e) }
}

/// An int that is true when the value is.
pub(super) fn truth(op: &Op, e: Expr) -> Fit<Expr> {
    let e = single(op, e)?;
    if e.ty == Type::INT {
        return Ok(e);
    }
    let span = e.span;
    Ok(Expr { kind: ExprKind::Truth(Box::new(e)), ty: Type::INT, span })
}

/// A value as one of another type, as `assign` converts.
pub(super) fn fitted(op: &Op, e: Expr, to: Type) -> Fit<Expr> {
    if e.ty == to {
        return Ok(e);
    }
    let triple = |b: Base| b.is_triple();
    let fits = match (to.extent, e.ty.extent) {
        // The destination may be longer: its other elements stay as they are.
        (Extent::Fixed(a), Extent::Fixed(b)) => {
            let same = to.base == e.ty.base || triple(to.base) && triple(e.ty.base);
            return if same && a >= b { Ok(e) } else { Err(mismatch(op, e.ty, to)) };
        }
        (Extent::Scalar, Extent::Scalar) => match (to.base, e.ty.base) {
            (Base::Int | Base::Float, Base::Int | Base::Float) => true,
            (t, Base::Int | Base::Float) if triple(t) || t == Base::Matrix => true,
            (Base::Closure, Base::Int) => matches!(e.kind, ExprKind::Int(0)),
            (Base::Closure, Base::Float) => matches!(e.kind, ExprKind::Float(v) if v == 0.0),
            (t, f) => triple(t) && triple(f),
        },
        _ => false,
    };
    if !fits {
        return Err(mismatch(op, e.ty, to));
    }
    let span = e.span;
    Ok(Expr { kind: ExprKind::Convert(Box::new(e)), ty: to, span })
}

fn mismatch(op: &Op, from: Type, to: Type) -> Diagnostic {
    let show = |t: Type| super::SymType { element: Element::Base(t.base), extent: t.extent }.spelling();
    unfit(op, format!("cannot turn {} into {}", show(from), show(to)))
}
