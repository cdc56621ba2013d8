//! Declarations: shaders, parameters, functions, structs, metadata.

use super::typed::{Expr, Function, FunctionId, Param, Struct, Var, VarId, VarKind, VendorClosure};
use super::{Checker, constant, typed};
use crate::ast;
use crate::builtins::sig;
use crate::diag::Diagnostic;
use crate::reflect::{self, ShaderInfo};
use crate::types::{Base, Extent, StructId, Type};
use crate::vendor;

use super::scope::Symbol;

impl Checker {
    pub(super) fn file(&mut self, file: &ast::File) -> Option<(typed::Shader, ShaderInfo)> {
        let mut found: Option<(typed::Shader, ShaderInfo)> = None;
        let mut first: Option<crate::source::Span> = None;
        for item in &file.items {
            if let ast::Item::Function(f) = item {
                self.later.insert(f.name.name.clone(), f.name.span);
            }
        }
        for item in &file.items {
            match item {
                ast::Item::Struct(s) => self.structure(s),
                ast::Item::Function(f) => self.function(f),
                ast::Item::Shader(s) => {
                    if let Some(at) = first {
                        if self.incomplete {
                            continue;
                        }
                        let d = Diagnostic::error("E2013", s.name.span, "a file holds one shader only")
                            .label(at, "the first one");
                        self.error(d);
                        continue;
                    }
                    first = Some(s.name.span);
                    found = self.shader(s);
                }
            }
        }
        self.check_recursion();
        self.check_returns();
        if let Some((shader, _)) = &found {
            self.check_writes(shader);
        }
        let (mut shader, info) = found?;
        shader.vars = std::mem::take(&mut self.vars);
        shader.structs = std::mem::take(&mut self.structs);
        shader.functions = std::mem::take(&mut self.functions);
        Some((shader, info))
    }

    fn shader(&mut self, s: &ast::Shader) -> Option<(typed::Shader, ShaderInfo)> {
        let metadata = self.metadata(&s.metadata);
        self.scopes.enter_joined();
        let mut params = Vec::new();
        let mut infos = Vec::new();
        for (index, p) in s.params.iter().enumerate() {
            if let Some((param, info)) = self.shader_param(p, index as u32) {
                params.push(param);
                infos.push(info);
            }
        }
        self.returns = Some(Type::VOID);
        let body = self.body_block(&s.body);
        self.returns = None;
        self.scopes.leave();
        let info = ShaderInfo { name: s.name.name.clone(), kind: s.kind.name.clone(), metadata, params: infos };
        let shader = typed::Shader {
            name: s.name.name.clone(),
            kind: s.kind.name.clone(),
            params,
            body,
            vars: Vec::new(),
            structs: Vec::new(),
            functions: Vec::new(),
        };
        Some((shader, info))
    }

    fn shader_param(&mut self, p: &ast::Param, index: u32) -> Option<(Param, reflect::Param)> {
        let Some(ty) = self.declared_type(&p.ty, &p.array, true) else {
            self.scopes.declare_broken(&p.name.name);
            return None;
        };
        if ty.base == Base::Void {
            self.scopes.declare_broken(&p.name.name);
            return self.fail(Diagnostic::error("E2013", p.ty.span, "a parameter cannot be void"));
        }
        if ty.extent == Extent::Unsized && p.output {
            let message = format!("output parameter `{}` needs a length", p.name.name);
            self.error(
                Diagnostic::error("E2013", p.name.span, message).help("only inputs may leave it open: `name[3]`"),
            );
        }
        let metadata = self.metadata(&p.metadata);
        let init = match &p.init {
            None => {
                let message = format!("shader parameter `{}` needs a default value", p.name.name);
                self.error(Diagnostic::error("E2013", p.name.span, message).help("add `= value`"));
                None
            }
            // An empty list leaves a struct or array parameter undefined until it is bound.
            Some(ast::Init::List(items, _)) if items.is_empty() => None,
            Some(init) => self.assigned(init, ty, &format!("parameter `{}`", p.name.name)),
        };
        let ty = self.settle_extent(ty, init.as_ref());
        let open = matches!(p.array, Some(ast::ArraySize::Unsized));
        let (varying, traits) = reflect::hints(&metadata, open);
        let kind = VarKind::ShaderParam(index);
        let var = self.declare(&p.name, ty, kind, p.output);
        if open {
            self.open.insert(var);
        }
        let fields = match ty.base {
            Base::Struct(id) => self.flat_fields(id, ""),
            _ => Vec::new(),
        };
        let shown = match (p.array.as_ref(), ty.extent) {
            (Some(ast::ArraySize::Unsized), _) => self.show(Type { extent: Extent::Unsized, ..ty }),
            _ => self.show(ty),
        };
        let info = reflect::Param {
            name: p.name.name.clone(),
            ty: shown,
            resolved: ty,
            output: p.output,
            default: init.as_ref().and_then(constant::value),
            fields,
            metadata,
        };
        Some((Param { var, output: p.output, init, varying, traits }, info))
    }

    fn flat_fields(&self, id: StructId, prefix: &str) -> Vec<reflect::Field> {
        let mut out = Vec::new();
        for (name, ty) in &self.structs[id.0 as usize].fields {
            let name = format!("{prefix}{name}");
            match ty.base {
                Base::Struct(inner) if !ty.is_array() => out.extend(self.flat_fields(inner, &format!("{name}."))),
                _ => out.push(reflect::Field { name, ty: self.show(*ty) }),
            }
        }
        out
    }

    /// An unsized array takes the length of its initial value (1 without one).
    pub(super) fn settle_extent(&mut self, ty: Type, init: Option<&Expr>) -> Type {
        if ty.extent != Extent::Unsized {
            return ty;
        }
        let extent = match init.map(|e| e.ty.extent) {
            Some(Extent::Fixed(n)) => Extent::Fixed(n),
            _ => Extent::Fixed(1),
        };
        Type { base: ty.base, extent }
    }

    /// Declares a variable in the innermost scope.
    pub(super) fn declare(&mut self, name: &ast::Ident, ty: Type, kind: VarKind, writable: bool) -> VarId {
        self.check_reserved(name);
        self.check_unused(name, matches!(kind, VarKind::ShaderParam(_)));
        let id = self.new_var(Var { name: name.name.clone(), ty, kind, writable, span: name.span });
        self.scopes.declare_var(&name.name, id);
        id
    }

    /// The type of a declaration. Unsized arrays only where `unsized_ok`.
    pub(super) fn declared_type(
        &mut self,
        spec: &ast::TypeSpec,
        array: &Option<ast::ArraySize>,
        unsized_ok: bool,
    ) -> Option<Type> {
        let base = self.base(spec)?;
        let extent = match array {
            None => Extent::Scalar,
            Some(ast::ArraySize::Unsized) if unsized_ok => Extent::Unsized,
            Some(ast::ArraySize::Unsized) => {
                let d = Diagnostic::error("E2011", spec.span, "this array needs a length");
                return self.fail(d.help("only parameters may leave it open"));
            }
            Some(ast::ArraySize::Fixed(e)) => Extent::Fixed(self.array_length(e)?),
        };
        if extent != Extent::Scalar && base == Base::Void {
            return self.fail(Diagnostic::error("E2011", spec.span, "there are no arrays of void"));
        }
        if let (Base::Struct(id), true) = (base, extent != Extent::Scalar)
            && self.structs[id.0 as usize].fields.iter().any(|(_, t)| t.is_array())
        {
            let d = Diagnostic::error("E2011", spec.span, "an array of structs cannot hold arrays in its fields");
            return self.fail(d);
        }
        Some(Type { base, extent })
    }

    fn array_length(&mut self, e: &ast::Expr) -> Option<u32> {
        let typed = self.expr(e, None)?;
        match constant::value(&typed) {
            Some(reflect::Value::Int(n)) if n >= 1 => Some(n as u32),
            Some(reflect::Value::Int(n)) => {
                self.fail(Diagnostic::error("E2011", e.span, format!("an array cannot have {n} elements")))
            }
            _ => self.fail(Diagnostic::error("E2011", e.span, "an array's length must be a constant int")),
        }
    }

    /// The base type of a spelling.
    pub(super) fn base(&mut self, spec: &ast::TypeSpec) -> Option<Base> {
        use ast::TypeName;
        Some(match &spec.name {
            TypeName::Int => Base::Int,
            TypeName::Float => Base::Float,
            TypeName::Color => Base::Color,
            TypeName::Point => Base::Point,
            TypeName::Vector => Base::Vector,
            TypeName::Normal => Base::Normal,
            TypeName::Matrix => Base::Matrix,
            TypeName::String => Base::String,
            TypeName::Void => Base::Void,
            TypeName::Closure => Base::Closure,
            TypeName::Struct(name) => match self.scopes.find(name) {
                Some(Symbol::Struct(id)) => Base::Struct(*id),
                Some(Symbol::Broken) => return None,
                _ => {
                    let mut d = Diagnostic::error("E2002", spec.span, format!("there is no type `{name}`"));
                    if name == "light" {
                        d = d.help("OSL has no light shaders: lights are surfaces with emission()");
                    }
                    let structs = self.scopes.names(|s| matches!(s, Symbol::Struct(_)));
                    let keywords = ["int", "float", "color", "point", "vector", "normal", "matrix", "string", "void"];
                    if let Some(near) = crate::suggest::closest(name, structs.chain(keywords)) {
                        d = d.help(format!("did you mean `{near}`?"));
                    }
                    return self.fail(d);
                }
            },
        })
    }

    pub(super) fn structure(&mut self, s: &ast::Struct) {
        self.check_reserved(&s.name);
        if !self.check_unused(&s.name, false) {
            return;
        }
        let mut fields: Vec<(String, Type)> = Vec::new();
        for f in &s.fields {
            if fields.iter().any(|(n, _)| *n == f.name.name) {
                let message = format!("struct `{}` has two fields `{}`", s.name.name, f.name.name);
                self.error(Diagnostic::error("E2012", f.name.span, message));
                continue;
            }
            if let Some(ty) = self.declared_type(&f.ty, &f.array, false) {
                if ty.base == Base::Void {
                    self.error(Diagnostic::error("E2012", f.ty.span, "a field cannot be void"));
                }
                fields.push((f.name.name.clone(), ty));
            }
        }
        if s.fields.is_empty() && !self.incomplete {
            self.error(Diagnostic::error("E2012", s.name.span, format!("struct `{}` has no fields", s.name.name)));
        }
        let id = StructId(self.structs.len() as u32);
        self.structs.push(Struct { name: s.name.name.clone(), fields });
        self.scopes.declare_struct(&s.name.name, id);
    }

    pub(super) fn function(&mut self, f: &ast::Function) {
        let ret = self.base(&f.ret).map(Type::scalar);
        // Parameters first: they decide which overload this is.
        self.scopes.enter();
        let mut params = Vec::new();
        let mut broken = false;
        for p in &f.params {
            let Some(ty) = self.declared_type(&p.ty, &p.array, true) else {
                broken = true;
                continue;
            };
            if ty.base == Base::Void {
                self.error(Diagnostic::error("E2013", p.ty.span, "a parameter cannot be void"));
                broken = true;
                continue;
            }
            if p.init.is_some() {
                let message = format!("function parameter `{}` cannot have a default value", p.name.name);
                self.error(Diagnostic::error("E2013", p.name.span, message));
            }
            let id = self.declare(&p.name, ty, VarKind::FunctionParam, p.output);
            params.push((id, p.output));
        }
        self.metadata(&f.metadata);
        self.scopes.leave();
        self.check_reserved(&f.name);
        let Some(ret) = ret.filter(|_| !broken) else {
            self.scopes.declare_broken(&f.name.name);
            if let (Some(body), false) = (&f.body, broken) {
                self.function_body(None, None, &params, body);
            }
            return;
        };
        if let Some(Symbol::Var(_) | Symbol::Struct(_)) = self.scopes.find_here(&f.name.name) {
            self.check_unused(&f.name, false);
            return;
        }
        let types: Vec<Type> = params.iter().map(|(v, _)| self.var(*v).ty).collect();
        let id = self.function_slot(f, ret, &types, params.clone());
        let Some(body) = &f.body else { return };
        if sig::by_name(&f.name.name).is_some() && f.body.is_some() && self.shadows_builtin(f, &types) {
            let message = format!("`{}` hides the built-in function with the same parameters", f.name.name);
            self.warn(Diagnostic::warning("W2001", f.name.span, message));
        }
        let (stmts, returned) = self.function_body(Some(id), Some(ret), &params, body);
        if ret != Type::VOID && !returned {
            self.without_return.insert(id, false);
        }
        let slot = &mut self.functions[id.0 as usize];
        slot.body = Some(stmts);
        slot.params = params;
    }

    /// Checks the body of a function: its statements, and whether they hold a `return`.
    fn function_body(
        &mut self,
        id: Option<FunctionId>,
        ret: Option<Type>,
        params: &[(VarId, bool)],
        body: &ast::Block,
    ) -> (Vec<typed::Stmt>, bool) {
        let outer = (self.current, self.loops, self.returns, self.returned);
        (self.current, self.loops, self.returns, self.returned) = (id, 0, ret, false);
        self.scopes.enter();
        for (var, _) in params {
            let name = self.var(*var).name.clone();
            self.scopes.declare_var(&name, *var);
        }
        let stmts = self.body_block(body);
        self.scopes.leave();
        let returned = self.returned;
        (self.current, self.loops, self.returns, self.returned) = outer;
        (stmts, returned)
    }

    /// A function without `return` is wrong where it is called; the others are worth a word.
    fn check_returns(&mut self) {
        let mut uncalled: Vec<FunctionId> =
            self.without_return.iter().filter(|(_, called)| !**called).map(|(id, _)| *id).collect();
        uncalled.sort_unstable();
        for id in uncalled {
            let function = &self.functions[id.0 as usize];
            let message =
                format!("function `{}` returns {}, but has no `return`", function.name, self.show(function.ret));
            let d = Diagnostic::warning("W2007", function.span, message);
            self.warn(d);
        }
    }

    /// The slot of a function: that of its forward declaration, or a new one.
    fn function_slot(
        &mut self,
        f: &ast::Function,
        ret: Type,
        types: &[Type],
        params: Vec<(VarId, bool)>,
    ) -> FunctionId {
        if let Some(Symbol::Functions(list)) = self.scopes.find_here(&f.name.name) {
            for id in list.clone() {
                let old = &self.functions[id.0 as usize];
                let same = old.params.len() == types.len()
                    && old.params.iter().zip(types).all(|((v, _), t)| self.var(*v).ty == *t);
                if !same {
                    continue;
                }
                let (has_body, at, same_result) = (old.body.is_some(), old.span, old.ret == ret);
                if same_result && !has_body {
                    return id;
                }
                if same_result && has_body && f.body.is_some() {
                    let message = format!("function `{}` is already defined with these parameters", f.name.name);
                    self.warn(Diagnostic::warning("W2001", f.name.span, message).label(at, "here"));
                }
            }
        }
        let id = FunctionId(self.functions.len() as u32);
        let closure = match vendor::metadata(f, "tokens").and_then(|n| u32::try_from(n).ok()) {
            _ if ret.base != Base::Closure => VendorClosure::No,
            _ if vendor::is_declaration(f) => VendorClosure::Unknown,
            Some(tokens) if f.body.is_some() => VendorClosure::Mapped { tokens: tokens.min(params.len() as u32) },
            _ => VendorClosure::No,
        };
        let name = f.name.name.clone();
        self.functions.push(Function { name, ret, params, body: None, closure, span: f.name.span });
        self.scopes.declare_function(&f.name.name, id);
        id
    }

    fn shadows_builtin(&self, f: &ast::Function, types: &[Type]) -> bool {
        sig::by_name(&f.name.name).is_some_and(|id| {
            sig::overloads(id).iter().any(|o| {
                o.formals.len() == types.len() && o.formals.iter().zip(types).all(|(formal, t)| formal.ty == Some(*t))
            })
        })
    }

    fn metadata(&mut self, list: &[ast::Metadata]) -> Vec<reflect::Metadata> {
        let mut out: Vec<reflect::Metadata> = Vec::new();
        for m in list {
            let Some(ty) = self.declared_type(&m.ty, &m.array, true) else { continue };
            if matches!(ty.base, Base::Struct(_) | Base::Closure | Base::Void) {
                let message = format!("metadata cannot be of type {}", self.show(ty));
                self.error(Diagnostic::error("E2014", m.ty.span, message));
                continue;
            }
            let Some(init) = self.initial(&m.value, ty, &format!("metadata `{}`", m.name.name)) else { continue };
            let value = constant::value(&init);
            if value.is_none() {
                let message = format!("the value of metadata `{}` must be a constant", m.name.name);
                self.error(Diagnostic::error("E2014", init.span, message));
            }
            let ty = self.settle_extent(ty, Some(&init));
            out.push(reflect::Metadata { name: m.name.name.clone(), ty: self.show(ty), value });
        }
        out
    }
}
