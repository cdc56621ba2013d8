//! Typed tree to [`Module`](super::Module): symbols. Where variables live, places inside them, constants, parameters.
//!
//! In: variables and parameters of the tree. Out: symbols, and operations that read and store places. It must not know
//! statements or expressions.

use super::write::Writer;
use super::{Access, Element, Hint, HintArg, Literal, SymId, SymType, Symbol, SymbolKind, number};
use crate::check::constant;
use crate::check::typed::{Expr, ExprKind, Param, VarId, VarKind};
use crate::reflect::{self, Value};
use crate::source::{FileId, Span};
use crate::types::{Base, Extent, StructId, Type};

/// The symbols of a variable.
#[derive(Clone, Debug)]
pub(super) enum Home {
    /// One symbol, possibly an array.
    One(SymId),
    /// A struct's own symbol and the homes of its fields.
    Fields(SymId, Vec<Home>),
}

impl Home {
    /// The symbol that stands for the whole.
    pub fn symbol(&self) -> SymId {
        match self {
            Home::One(id) | Home::Fields(id, _) => *id,
        }
    }
}

/// Something that can be read or assigned.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// A variable or a part of one that has symbols of its own.
    Home(Home),
    /// An element of an array; of an array of structs, of each of its fields.
    Element(Home, SymId),
    /// A component of a triple.
    Component(Box<Place>, SymId),
    /// Row and column of a matrix.
    Cell(Box<Place>, SymId, SymId),
}

/// A metadatum as a hint; `None` when it has no value.
pub(super) fn meta(m: &reflect::Metadata) -> Option<Hint> {
    let mut args = vec![HintArg::Word(m.ty.replace(' ', "")), HintArg::Word(m.name.clone())];
    let mut values = Vec::new();
    let triple = ["color", "point", "vector", "normal", "matrix"].iter().any(|t| m.ty.starts_with(t));
    literals(m.value.as_ref()?, triple || m.ty.starts_with("float"), &mut values);
    args.extend(values.iter().map(|v| match v {
        Literal::Int(i) => HintArg::Word(i.to_string()),
        Literal::Float(f) => HintArg::Word(number::exact(*f)),
        Literal::Str(s) => HintArg::Str(s.clone()),
    }));
    Some(Hint { name: "meta".to_owned(), args })
}

/// A value's leaves.
fn literals(value: &Value, float: bool, out: &mut Vec<Literal>) {
    match value {
        Value::Int(v) if float => out.push(Literal::Float(f64::from(*v))),
        Value::Int(v) => out.push(Literal::Int(*v)),
        Value::Float(v) => out.push(Literal::Float(*v)),
        Value::Str(s) => out.push(Literal::Str(s.clone())),
        Value::List(items) => items.iter().for_each(|v| literals(v, float, out)),
    }
}

/// The code letter of a type, as `%structfieldtypes` has it.
fn letter(base: Base) -> String {
    match base {
        Base::Void => "x".to_owned(),
        Base::Int => "i".to_owned(),
        Base::Float => "f".to_owned(),
        Base::Color => "c".to_owned(),
        Base::Point => "p".to_owned(),
        Base::Vector => "v".to_owned(),
        Base::Normal => "n".to_owned(),
        Base::Matrix => "m".to_owned(),
        Base::String => "s".to_owned(),
        Base::Closure => "C".to_owned(),
        Base::Struct(StructId(i)) => format!("S{}", i + 1),
    }
}

impl Writer<'_> {
    fn sym_type(&self, ty: Type) -> SymType {
        let element = match ty.base {
            Base::Struct(id) => Element::Struct(self.tree.structure(id).name.clone()),
            base => Element::Base(base),
        };
        SymType { element, extent: ty.extent }
    }

    pub(super) fn add(&mut self, kind: SymbolKind, ty: SymType, name: String) -> SymId {
        let span = Span { file: FileId(0), start: 0, end: 0 };
        let symbol = Symbol { kind, ty, name, values: Vec::new(), hints: Vec::new(), uses: [None; 2], span };
        self.module.symbols.push(symbol);
        SymId(self.module.symbols.len() as u32 - 1)
    }

    /// Symbols for a variable of an OSL type; `root` is the outermost struct's symbol and this field's index.
    pub(super) fn make(&mut self, kind: SymbolKind, ty: Type, name: String) -> Home {
        self.make_field(kind, ty, name, None)
    }

    fn make_field(&mut self, kind: SymbolKind, ty: Type, name: String, root: Option<(&str, usize)>) -> Home {
        let id = self.add(kind, self.sym_type(ty), name.clone());
        let word = |t: &str| HintArg::Word(t.to_owned());
        if let Some((root, index)) = root {
            self.hint(id, "mystruct", vec![word(root)]);
            self.hint(id, "mystructfield", vec![word(&index.to_string())]);
        }
        let Base::Struct(structure) = ty.base else { return Home::One(id) };
        let structure = self.tree.structure(structure).clone();
        let names: Vec<&str> = structure.fields.iter().map(|(n, _)| n.as_str()).collect();
        let types: String = structure
            .fields
            .iter()
            .map(|(_, t)| match t.extent {
                Extent::Fixed(n) => format!("{}[{n}]", letter(t.base)),
                Extent::Unsized => format!("{}[]", letter(t.base)),
                Extent::Scalar => letter(t.base),
            })
            .collect();
        self.hint(id, "struct", vec![HintArg::Str(structure.name.clone())]);
        self.hint(id, "structfields", names.iter().map(|n| word(n)).collect());
        self.hint(id, "structfieldtypes", vec![HintArg::Str(types)]);
        self.hint(id, "structnfields", vec![word(&names.len().to_string())]);
        let fields = structure
            .fields
            .iter()
            .enumerate()
            .map(|(i, (field, field_ty))| {
                // An array of structs has no arrays inside (checked), so one length is enough.
                let extent = if field_ty.is_array() { field_ty.extent } else { ty.extent };
                let inner = Type { base: field_ty.base, extent };
                self.make_field(kind, inner, format!("{name}.{field}"), Some((&name, i)))
            })
            .collect();
        Home::Fields(id, fields)
    }

    fn hint(&mut self, id: SymId, name: &str, args: Vec<HintArg>) {
        self.module.symbols[id.0 as usize].hints.push(Hint { name: name.to_owned(), args });
    }

    /// A variable of the compiler's own.
    pub(super) fn temp(&mut self, ty: Type) -> Home {
        self.temps += 1;
        self.make(SymbolKind::Temp, ty, format!("$tmp{}", self.temps))
    }

    /// As [`Writer::temp`], of a type that is no struct.
    pub(super) fn temp_symbol(&mut self, ty: Type) -> SymId {
        self.temp(ty).symbol()
    }

    /// A local variable comes to life. One that a function inlined before had is used again.
    pub(super) fn declare(&mut self, var: VarId) -> Home {
        if let Some(home) = self.env.get(&var) {
            return home.clone();
        }
        let declared = self.tree.var(var).clone();
        let home = self.make(SymbolKind::Local, declared.ty, format!("___{}_{}", var.0, declared.name));
        self.env.insert(var, home.clone());
        home
    }

    /// The symbols of a variable; globals come to life when first used.
    pub(super) fn variable(&mut self, var: VarId) -> Home {
        if let Some(home) = self.env.get(&var) {
            return home.clone();
        }
        let declared = self.tree.var(var).clone();
        if declared.kind != VarKind::Global {
            return self.declare(var);
        }
        let home = self.make(SymbolKind::Global, declared.ty, declared.name);
        self.env.insert(var, home.clone());
        home
    }

    /// The constant with these values.
    pub(super) fn constant(&mut self, ty: Type, values: Vec<Literal>) -> SymId {
        let mut key = format!("{ty:?}");
        for v in &values {
            key += &match v {
                Literal::Int(i) => format!(" {i}"),
                Literal::Float(f) => format!(" {:x}", f.to_bits()),
                Literal::Str(s) => format!(" {s:?}"),
            };
        }
        if let Some(id) = self.constants.get(&key) {
            return *id;
        }
        let name = format!("$const{}", self.constants.len() + 1);
        let id = self.add(SymbolKind::Const, self.sym_type(ty), name);
        self.module.symbols[id.0 as usize].values = values;
        self.constants.insert(key, id);
        id
    }

    pub(super) fn int(&mut self, v: i32) -> SymId {
        self.constant(Type::INT, vec![Literal::Int(v)])
    }

    pub(super) fn float(&mut self, v: f64) -> SymId {
        self.constant(Type::FLOAT, vec![Literal::Float(v)])
    }

    pub(super) fn string(&mut self, s: &str) -> SymId {
        self.constant(Type::STRING, vec![Literal::Str(s.to_owned())])
    }

    /// The type of a symbol that is no struct.
    pub(super) fn type_of(&self, id: SymId) -> Type {
        let ty = &self.module.symbol(id).ty;
        Type { base: ty.base().unwrap_or(Base::Void), extent: ty.extent }
    }

    /// The symbols of a shader parameter.
    pub(super) fn param(&mut self, param: &Param, info: &reflect::Param) {
        let var = self.tree.var(param.var);
        let ty = if info.ty.ends_with("[]") { Type { extent: Extent::Unsized, ..var.ty } } else { var.ty };
        let kind = if param.output { SymbolKind::OutputParam } else { SymbolKind::Param };
        let home = self.make(kind, ty, var.name.clone());
        for m in info.metadata.iter().filter_map(meta) {
            self.module.symbols[home.symbol().0 as usize].hints.push(m);
        }
        self.env.insert(param.var, home);
    }

    /// Values of a parameter's default, or a section of code for each symbol whose value must be computed.
    pub(super) fn param_default(&mut self, param: &Param) {
        let Some(home) = self.env.get(&param.var).cloned() else { return };
        self.leaf_default(&home, param.init.as_ref(), &mut Vec::new());
    }

    /// `path` leads from the parameter to this leaf; `init` is this leaf's own, or absent below an expression.
    fn leaf_default(&mut self, home: &Home, init: Option<&Expr>, path: &mut Vec<usize>) {
        if let Home::Fields(id, fields) = home {
            let items = match init.map(|e| &e.kind) {
                Some(ExprKind::List(items)) => Some(items),
                _ => None,
            };
            let array = self.module.symbol(*id).ty.extent != Extent::Scalar;
            for (i, field) in fields.iter().enumerate() {
                match (items, array) {
                    // An expression gives the whole struct: each leaf takes its part of it.
                    (None, _) if init.is_some() => {
                        path.push(i);
                        self.computed(field, init, path);
                        path.pop();
                    }
                    (Some(items), false) => self.leaf_default(field, items.get(i), path),
                    // An array of structs: constants are told apart by field.
                    (Some(items), true) => {
                        let parts: Option<Vec<Value>> = items.iter().map(|e| part(constant::value(e)?, i)).collect();
                        match parts {
                            Some(values) => self.give_values(field, &Value::List(values)),
                            None => {
                                path.push(i);
                                self.computed(field, init, path);
                                path.pop();
                            }
                        }
                    }
                    (None, _) => self.leaf_default(field, None, path),
                }
            }
            return;
        }
        match init.map(|e| (e, constant::value(e))) {
            None => self.give_zeros(home),
            Some((_, Some(value))) => self.give_values(home, &value),
            Some((e, _)) if matches!(e.kind, ExprKind::Convert(ref inner) if e.ty.base == Base::Closure && inner.ty != e.ty) =>
                {}
            Some((e, None)) => self.computed(home, Some(e), &[]),
        }
    }

    /// A section that computes one leaf: of `init` its part at `path`.
    fn computed(&mut self, home: &Home, init: Option<&Expr>, path: &[usize]) {
        let Some(e) = init else { return };
        if let Home::Fields(_, fields) = home {
            for (i, field) in fields.iter().enumerate() {
                let mut path = path.to_vec();
                path.push(i);
                self.computed(field, init, &path);
            }
            return;
        }
        self.give_zeros(home);
        let name = self.module.symbol(home.symbol()).name.clone();
        self.hint(home.symbol(), "initexpr", Vec::new());
        self.section(&name);
        self.locate(e.span);
        if path.is_empty() {
            self.assign(&Place::Home(home.clone()), e);
            return;
        }
        let mut source = Place::Home(self.home(e));
        for i in path {
            source = source.field(*i);
        }
        self.copy(&Place::Home(home.clone()), &source);
    }

    fn give_values(&mut self, home: &Home, value: &Value) {
        let id = home.symbol();
        let Some(base) = self.module.symbol(id).ty.base() else { return };
        let float = base == Base::Float || base == Base::Matrix || base.is_triple();
        let mut values = Vec::new();
        literals(value, float, &mut values);
        if base != Base::Closure {
            self.module.symbols[id.0 as usize].values = values;
        }
    }

    /// Placeholders of what is computed or undefined.
    fn give_zeros(&mut self, home: &Home) {
        if let Home::Fields(_, fields) = home {
            fields.iter().for_each(|f| self.give_zeros(f));
            return;
        }
        let symbol = &mut self.module.symbols[home.symbol().0 as usize];
        let zero = match symbol.ty.base() {
            Some(Base::Int) => Literal::Int(0),
            Some(Base::String) => Literal::Str(String::new()),
            Some(Base::Closure | Base::Void) | None => return,
            _ => Literal::Float(0.0),
        };
        let elements = match symbol.ty.extent {
            Extent::Fixed(n) => n as usize,
            _ => 1,
        };
        symbol.values = vec![zero; (elements * symbol.ty.components()).min(1 << 16)];
    }

    /// Leaves out globals, locals, temporaries and constants that no operation names.
    pub(super) fn drop_unused(&mut self) {
        let mut used: Vec<bool> = self.module.symbols.iter().map(|s| s.kind.is_param()).collect();
        for op in &self.module.ops {
            op.args.iter().for_each(|a| used[a.0 as usize] = true);
        }
        // A struct stays with its fields.
        for i in 0..used.len() {
            if !used[i] && self.module.symbols[i].hint("struct").is_some() {
                let inside = format!("{}.", self.module.symbols[i].name);
                used[i] = (i + 1..used.len())
                    .take_while(|j| self.module.symbols[*j].name.starts_with(&inside))
                    .any(|j| used[j]);
            }
        }
        let mut next = 0;
        let renamed: Vec<SymId> = used
            .iter()
            .map(|u| {
                let id = SymId(next);
                next += u32::from(*u);
                id
            })
            .collect();
        let mut keep = used.iter();
        self.module.symbols.retain(|_| keep.next().copied().unwrap_or(false));
        for op in &mut self.module.ops {
            op.args.iter_mut().for_each(|a| *a = renamed[a.0 as usize]);
        }
    }

    /// Finds the first and last operation that reads and that writes each symbol. Within a loop, that is the loop's.
    pub(super) fn mark_uses(&mut self) {
        let mut ends: Vec<(u32, u32)> = Vec::new();
        for i in 0..self.module.ops.len() {
            let number = i as u32;
            ends.retain(|(_, end)| *end > number);
            let op = &self.module.ops[i];
            let (mut first, mut last) = (number, number);
            if let Some((start, end)) = ends.first() {
                (first, last) = (*start, end - 1);
            }
            for (arg, access) in op.args.clone().into_iter().zip(op.access.clone()) {
                let uses = &mut self.module.symbols[arg.0 as usize].uses;
                let mark = |use_: &mut Option<(u32, u32)>| {
                    let (a, b) = use_.unwrap_or((first, last));
                    *use_ = Some((a.min(first), b.max(last)));
                };
                if access != Access::Write {
                    mark(&mut uses[0]);
                }
                if access != Access::Read {
                    mark(&mut uses[1]);
                }
            }
            let op = &self.module.ops[i];
            if matches!(op.name.as_str(), "for" | "while" | "dowhile")
                && let Some(end) = op.jumps.last()
            {
                ends.push((number, *end));
            }
        }
    }
}

/// Field `index` of a struct's constant.
fn part(value: Value, index: usize) -> Option<Value> {
    match value {
        Value::List(items) => items.into_iter().nth(index),
        _ => None,
    }
}

impl Place {
    /// A field of a struct place.
    pub fn field(self, index: usize) -> Place {
        match self {
            Place::Home(Home::Fields(_, fields)) if index < fields.len() => Place::Home(fields[index].clone()),
            Place::Element(Home::Fields(_, fields), at) if index < fields.len() => {
                Place::Element(fields[index].clone(), at)
            }
            // Fields of what is no struct are refused by the checker.
            other => other,
        }
    }

    /// The number of fields of a struct place.
    fn fields(&self) -> Option<usize> {
        match self {
            Place::Home(Home::Fields(_, f)) | Place::Element(Home::Fields(_, f), _) => Some(f.len()),
            _ => None,
        }
    }
}

impl Writer<'_> {
    /// The symbol that holds the value at a place of a type that is no struct.
    pub(super) fn load(&mut self, place: &Place) -> SymId {
        match place {
            Place::Home(home) => home.symbol(),
            Place::Element(home, index) => {
                let array = home.symbol();
                let to = self.temp_symbol(Type::scalar(self.type_of(array).base));
                self.op("aref", "wrr", &[to, array, *index]);
                to
            }
            Place::Component(base, index) => {
                let base = self.load(base);
                let to = self.temp_symbol(Type::FLOAT);
                self.op("compref", "wrr", &[to, base, *index]);
                to
            }
            Place::Cell(base, row, column) => {
                let base = self.load(base);
                let to = self.temp_symbol(Type::FLOAT);
                self.op("mxcompref", "wrrr", &[to, base, *row, *column]);
                to
            }
        }
    }

    /// Sets a place of a type that is no struct.
    pub(super) fn store(&mut self, place: &Place, value: SymId) {
        match place {
            Place::Home(home) => {
                let to = home.symbol();
                if to != value {
                    let array = self.type_of(to).is_array();
                    self.op(if array { "arraycopy" } else { "assign" }, "wr", &[to, value]);
                }
            }
            Place::Element(home, index) => {
                self.op("aassign", "wrr", &[home.symbol(), *index, value]);
            }
            Place::Component(base, index) => {
                let whole = self.load(base);
                self.op("compassign", "wrr", &[whole, *index, value]);
                if !matches!(**base, Place::Home(_)) {
                    self.store(base, whole);
                }
            }
            Place::Cell(base, row, column) => {
                let whole = self.load(base);
                self.op("mxcompassign", "wrrr", &[whole, *row, *column, value]);
                if !matches!(**base, Place::Home(_)) {
                    self.store(base, whole);
                }
            }
        }
    }

    /// Copies one place to another of the same type, field by field.
    pub(super) fn copy(&mut self, to: &Place, from: &Place) {
        if let (Some(n), Some(m)) = (to.fields(), from.fields()) {
            for i in 0..n.min(m) {
                self.copy(&to.clone().field(i), &from.clone().field(i));
            }
            return;
        }
        let value = self.load(from);
        self.store(to, value);
    }
}
