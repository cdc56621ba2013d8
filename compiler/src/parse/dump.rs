//! Prints the syntax tree as S-expressions, for snapshots.

use crate::ast::*;
use std::fmt::Write;

/// One item per line; bodies are indented by two spaces per level.
pub fn dump(file: &File) -> String {
    let mut out = String::new();
    for item in &file.items {
        match item {
            Item::Shader(s) => {
                let _ = writeln!(out, "({} {}{}", s.kind.name, s.name.name, metadata(&s.metadata));
                params(&mut out, &s.params);
                block(&mut out, &s.body, 1);
                out.push_str(")\n");
            }
            Item::Function(f) => function(&mut out, f, 0),
            Item::Struct(s) => structure(&mut out, s, 0),
        }
    }
    out
}

fn indent(out: &mut String, level: usize) {
    out.push_str(&"  ".repeat(level));
}

fn function(out: &mut String, f: &Function, level: usize) {
    indent(out, level);
    let _ = writeln!(out, "(function {} {}{}", type_name(&f.ret), f.name.name, metadata(&f.metadata));
    params(out, &f.params);
    if let Some(body) = &f.body {
        block(out, body, level + 1);
    }
    indent(out, level);
    out.push_str(")\n");
}

fn structure(out: &mut String, s: &Struct, level: usize) {
    indent(out, level);
    let _ = write!(out, "(struct {}", s.name.name);
    for f in &s.fields {
        let _ = write!(out, " ({} {}{})", type_name(&f.ty), f.name.name, array(&f.array));
    }
    out.push_str(")\n");
}

fn params(out: &mut String, list: &[Param]) {
    for p in list {
        let kind = if p.output { "output" } else { "param" };
        let value = p.init.as_ref().map_or(String::new(), |i| format!(" {}", init(i)));
        let (ty, len, meta) = (type_name(&p.ty), array(&p.array), metadata(&p.metadata));
        let _ = writeln!(out, "  ({kind} {ty} {}{len}{value}{meta})", p.name.name);
    }
}

fn metadata(list: &[Metadata]) -> String {
    let one = |m: &Metadata| format!(" [{} {}{} {}]", type_name(&m.ty), m.name.name, array(&m.array), init(&m.value));
    list.iter().map(one).collect()
}

fn type_name(ty: &TypeSpec) -> &str {
    match &ty.name {
        TypeName::Int => "int",
        TypeName::Float => "float",
        TypeName::Color => "color",
        TypeName::Point => "point",
        TypeName::Vector => "vector",
        TypeName::Normal => "normal",
        TypeName::Matrix => "matrix",
        TypeName::String => "string",
        TypeName::Void => "void",
        TypeName::Closure => "closure",
        TypeName::Struct(name) => name,
    }
}

fn array(size: &Option<ArraySize>) -> String {
    match size {
        None => String::new(),
        Some(ArraySize::Unsized) => "[]".into(),
        Some(ArraySize::Fixed(e)) => format!("[{}]", expr(e)),
    }
}

fn block(out: &mut String, b: &Block, level: usize) {
    for s in &b.stmts {
        stmt(out, s, level);
    }
}

fn stmt(out: &mut String, s: &Stmt, level: usize) {
    match &s.kind {
        StmtKind::Function(f) => return function(out, f, level),
        StmtKind::Struct(s) => return structure(out, s, level),
        _ => indent(out, level),
    }
    match &s.kind {
        StmtKind::Empty => out.push_str("(empty)\n"),
        StmtKind::Declare { ty, names } => {
            let _ = write!(out, "(declare {}", type_name(ty));
            for n in names {
                let value = n.init.as_ref().map_or(String::new(), |i| format!(" {}", init(i)));
                let _ = write!(out, " ({}{}{value})", n.name.name, array(&n.array));
            }
            out.push_str(")\n");
        }
        StmtKind::Expr(e) => {
            let _ = writeln!(out, "{}", expr(e));
        }
        StmtKind::Block(b) => nested(out, "(block", level, |out| block(out, b, level + 1)),
        StmtKind::If { cond, then, otherwise } => nested(out, &format!("(if {}", expr(cond)), level, |out| {
            stmt(out, then, level + 1);
            if let Some(otherwise) = otherwise {
                stmt(out, otherwise, level + 1);
            }
        }),
        StmtKind::While { cond, body } => {
            nested(out, &format!("(while {}", expr(cond)), level, |out| stmt(out, body, level + 1));
        }
        StmtKind::DoWhile { body, cond } => {
            nested(out, &format!("(do-while {}", expr(cond)), level, |out| stmt(out, body, level + 1));
        }
        StmtKind::For { init, cond, step, body } => {
            let part = |e: &Option<Expr>| e.as_ref().map_or("()".to_string(), expr);
            nested(out, &format!("(for {} {}", part(cond), part(step)), level, |out| {
                stmt(out, init, level + 1);
                stmt(out, body, level + 1);
            });
        }
        StmtKind::Break => out.push_str("(break)\n"),
        StmtKind::Continue => out.push_str("(continue)\n"),
        StmtKind::Return(None) => out.push_str("(return)\n"),
        StmtKind::Return(Some(value)) => {
            let _ = writeln!(out, "(return {})", init(value));
        }
        StmtKind::Function(_) | StmtKind::Struct(_) => {}
    }
}

fn nested(out: &mut String, head: &str, level: usize, body: impl FnOnce(&mut String)) {
    out.push_str(head);
    out.push('\n');
    body(out);
    indent(out, level);
    out.push_str(")\n");
}

fn init(value: &Init) -> String {
    match value {
        Init::Expr(e) => expr(e),
        Init::List(items, _) => format!("{{{}}}", items.iter().map(init).collect::<Vec<_>>().join(" ")),
    }
}

fn list(items: &[Init]) -> String {
    items.iter().map(|i| format!(" {}", init(i))).collect()
}

fn expr(e: &Expr) -> String {
    match &e.kind {
        ExprKind::Int(v) => v.to_string(),
        ExprKind::Float(v) => format!("{v:?}"),
        ExprKind::Str(s) => format!("{s:?}"),
        ExprKind::Name(n) => n.clone(),
        ExprKind::Index { base, index } => format!("(index {} {})", expr(base), expr(index)),
        ExprKind::Field { base, field } => format!("(field {} {})", expr(base), field.name),
        ExprKind::Call { callee, args } => format!("(call {}{})", callee.name, list(args)),
        ExprKind::Construct { ty, args } => format!("({}{})", type_name(ty), list(args)),
        ExprKind::Cast { ty, expr: e } => format!("(cast {} {})", type_name(ty), expr(e)),
        ExprKind::Unary { op, expr: e } => {
            let op = match op {
                UnaryOp::Neg => "neg",
                UnaryOp::Plus => "plus",
                UnaryOp::Not => "not",
                UnaryOp::Compl => "compl",
            };
            format!("({op} {})", expr(e))
        }
        ExprKind::IncDec { op, expr: e } => {
            let op = match op {
                IncDecOp::PreInc => "pre++",
                IncDecOp::PreDec => "pre--",
                IncDecOp::PostInc => "post++",
                IncDecOp::PostDec => "post--",
            };
            format!("({op} {})", expr(e))
        }
        ExprKind::Binary { op, lhs, rhs } => format!("({} {} {})", op.symbol(), expr(lhs), expr(rhs)),
        ExprKind::Assign { op, lhs, rhs } => {
            let op = op.map_or("", BinaryOp::symbol);
            format!("({op}= {} {})", expr(lhs), init(rhs))
        }
        ExprKind::Ternary { cond, then, otherwise } => {
            format!("(? {} {} {})", expr(cond), expr(then), expr(otherwise))
        }
        ExprKind::Comma(parts) => format!("(, {})", parts.iter().map(expr).collect::<Vec<_>>().join(" ")),
    }
}
