//! [`Module`] to the typed tree, on which the same lowering of built-ins goes on as from OSL.
//!
//! In: a module. Out: [`Checked`], or located errors. Structs stay the symbols of their fields; branches and loops become
//! statements again; an inlined function is a function without parameters that is called where it stood; a parameter's code
//! section is a function that returns its default. It must not know the IR or any target.

use super::read_call::{literal_value, meta};
use super::read_stmt::MAX_NESTING;
use super::{Element, Literal, MAIN, Module, Op, SymId, Symbol, SymbolKind};
use crate::check::typed::{
    Callee, Expr, ExprKind, Function, FunctionId, Param, Shader, Stmt, Struct, Var, VarId, VarKind, VendorClosure,
};
use crate::check::{Checked, GLOBALS, unmapped};
use crate::diag::Diagnostic;
use crate::reflect::{self, ShaderInfo, Value};
use crate::source::Span;
use crate::types::{Base, Extent, StructId, Traits, Type};
use std::collections::HashMap;

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
    let unknown = functions.iter().filter(|f| f.closure == VendorClosure::Unknown);
    let warnings = unknown.map(|f| unmapped(&f.name, f.span)).collect();
    let shader = Shader { name, kind, params, body, vars, structs, functions };
    Ok(Checked { shader, info, warnings })
}

/// What `return` leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Body {
    /// The shader.
    Main,
    /// The code of a parameter's default.
    Default(VarId),
    /// An inlined function.
    Function,
}

pub(super) struct Reader<'m> {
    pub module: &'m Module,
    pub vars: Vec<Var>,
    var_of: Vec<Option<VarId>>,
    functions: Vec<Function>,
    pub body: Body,
    pub nesting: usize,
    pub loops: u32,
    pub errors: Vec<Diagnostic>,
}

/// Says why an operation is refused.
pub(super) type Fit<T> = Result<T, Diagnostic>;

/// An error about an operation.
pub(super) fn unfit(op: &Op, message: impl std::fmt::Display) -> Diagnostic {
    Diagnostic::error("E5002", op.span, format!("operation `{}` {message}", op.name))
}

impl<'m> Reader<'m> {
    pub fn error(&mut self, d: Diagnostic) {
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

    pub fn function(&mut self, name: String, ret: Type, body: Vec<Stmt>, span: Span) -> FunctionId {
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
}
