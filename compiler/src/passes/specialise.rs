//! Binds parameters to values: a bound parameter's init becomes a store of the constant.

use crate::diag::Diagnostic;
use crate::interp::ops;
use crate::ir::{Block, Const, LocalId, Shader, Stmt, Ty};
use crate::source::Span;

/// Binds parameters by their flattened names. Values convert as OSL converts them: int to float, float to triple or
/// matrix; three numbers make a triple and sixteen a matrix.
pub fn specialise(shader: &mut Shader, bindings: &[(String, Const)]) -> Result<(), Vec<Diagnostic>> {
    let mut errors = Vec::new();
    for (name, value) in bindings {
        let Some(index) = shader.params.iter().position(|p| p.name == *name) else {
            errors.push(unknown(shader, name));
            continue;
        };
        let param = &shader.params[index];
        let (local, span, declared) = (param.local, param.span, param.declared);
        if param.traits.open
            && let Some(len) = length_of(value, shader.locals[local.0 as usize].ty)
        {
            shader.locals[local.0 as usize].len = Some(len);
        }
        // The init of a struct's first field may set the others too, which then keep their defaults.
        let init = match super::link::writes_others(shader, index) {
            true => std::mem::take(&mut shader.params[index].init),
            false => Block::default(),
        };
        let slot = &shader.locals[local.0 as usize];
        match fit(value, slot.ty, slot.len) {
            Some(Fitted::One(c)) => {
                let mut init = init;
                let v = shader.emit_constant(c, span, &mut init);
                init.stmts.push(Stmt::Store(local, v));
                shader.params[index].init = init;
            }
            Some(Fitted::Many(items)) => {
                let init = store_elements(shader, init, local, items, span);
                shader.params[index].init = init;
            }
            None => {
                let len = slot.len.map_or(String::new(), |n| format!("[{n}]"));
                let message = format!(
                    "parameter `{name}` is {}{len}, which {} does not fit",
                    declared.base.keyword(),
                    show(value)
                );
                errors.push(Diagnostic::error("E4002", span, message));
            }
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

enum Fitted {
    One(Const),
    Many(Vec<Const>),
}

fn unknown(shader: &Shader, name: &str) -> Diagnostic {
    let d = Diagnostic::global("E4001", format!("shader `{}` has no parameter `{name}`", shader.name));
    let names = shader.params.iter().map(|p| p.name.as_str());
    match crate::suggest::closest(name, names) {
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None if shader.params.is_empty() => d.help("it has no parameters"),
        None => {
            let all: Vec<&str> = shader.params.iter().map(|p| p.name.as_str()).take(12).collect();
            d.help(format!("its parameters: {}", all.join(", ")))
        }
    }
}

fn show(value: &Const) -> String {
    match value {
        Const::Int(v) => format!("{v}"),
        Const::Float(v) => format!("{v}"),
        Const::Triple(v) => format!("{v:?}"),
        Const::Matrix(_) => "a matrix".into(),
        Const::Str(s) => format!("\"{s}\""),
        Const::Array(items) => format!("a list of {}", items.len()),
    }
}

fn number(c: &Const) -> Option<f64> {
    match c {
        Const::Int(v) => Some(*v as f64),
        Const::Float(v) => Some(*v),
        _ => None,
    }
}

/// A value as OSL converts it to a type: one constant, or an array of them with zeros behind those that are given.
pub(crate) fn fitted(value: &Const, ty: Ty, len: Option<u32>) -> Option<Const> {
    Some(match fit(value, ty, len)? {
        Fitted::One(c) => c,
        Fitted::Many(mut items) => {
            items.resize(len.unwrap_or(1) as usize, ops::zero(ty)?);
            Const::Array(items)
        }
    })
}

/// The length that an unsized array of this element type gets from a value.
pub(crate) fn length_of(value: &Const, ty: Ty) -> Option<u32> {
    let Const::Array(items) = value else { return Some(1) };
    let width = match ty {
        Ty::Triple => 3,
        Ty::Matrix => 16,
        _ => 1,
    };
    let flat = width > 1 && !items.iter().any(|i| matches!(i, Const::Array(_) | Const::Triple(_) | Const::Matrix(_)));
    let len = if flat { items.len().div_ceil(width) } else { items.len() };
    u32::try_from(len).ok().filter(|n| *n > 0)
}

fn fit(value: &Const, ty: Ty, len: Option<u32>) -> Option<Fitted> {
    let Some(len) = len else { return single(value, ty).map(Fitted::One) };
    let Const::Array(items) = value else {
        return (len == 1).then(|| single(value, ty)).flatten().map(|c| Fitted::Many(vec![c]));
    };
    // Elements one by one, or as flat numbers.
    let width = match ty {
        Ty::Triple => 3,
        Ty::Matrix => 16,
        _ => 1,
    };
    let elements: Vec<Const> = if items.len() == len as usize * width && width > 1 {
        items.chunks(width).map(|c| Const::Array(c.to_vec())).collect()
    } else {
        items.clone()
    };
    if elements.len() > len as usize {
        return None;
    }
    elements.iter().map(|e| single(e, ty)).collect::<Option<Vec<_>>>().map(Fitted::Many)
}

fn single(value: &Const, ty: Ty) -> Option<Const> {
    if value.ty() == Some(ty) && !matches!(value, Const::Array(_)) {
        return Some(value.clone());
    }
    if let Const::Array(items) = value {
        let floats = items.iter().map(number).collect::<Option<Vec<f64>>>()?;
        return match (ty, floats.as_slice()) {
            (Ty::Triple, [x, y, z]) => Some(Const::Triple([*x, *y, *z])),
            (Ty::Matrix, m) => Some(Const::Matrix(m.try_into().ok()?)),
            (_, [_]) => single(&items[0], ty),
            _ => None,
        };
    }
    let x = number(value)?;
    Some(match ty {
        Ty::Float => Const::Float(x),
        Ty::Triple => Const::Triple([x; 3]),
        Ty::Matrix => Const::Matrix(ops::IDENTITY.map(|i| i * x)),
        // A whole number given as a float still is one.
        Ty::Int if x.fract() == 0.0 && x.abs() <= i32::MAX as f64 => Const::Int(x as i32),
        _ => return None,
    })
}

fn store_elements(shader: &mut Shader, mut init: Block, local: LocalId, items: Vec<Const>, span: Span) -> Block {
    for (i, item) in items.into_iter().enumerate() {
        let index = shader.emit_constant(Const::Int(i as i32), span, &mut init);
        let value = shader.emit_constant(item, span, &mut init);
        init.stmts.push(Stmt::StoreElem(local, index, value));
    }
    init
}
