//! Point clouds: which files a shader looks into, and whether somebody writes what it says.
//!
//! In: folded IR. Out of [`answer`]: the same without `cloud_write`, which is whether the file has a name where a shader runs over a
//! grid of points, and 0 in renders, with a warning. [`clouds`] lists the files that are looked into.

use super::Rays;
use super::review::add;
use super::strings::Strings;
use crate::builtins;
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, Rewriter, Shader, Stmt, Ty, Value};
use std::collections::BTreeSet;

/// The point clouds that a shader can ask for, by name, sorted. A name that is not one of a known set is an error.
pub fn clouds(shader: &Shader) -> Result<Vec<String>, Vec<Diagnostic>> {
    let mut calls = Vec::new();
    let asks =
        |func: builtins::FuncId| matches!(builtins::row(func).name, "cloud_count" | "cloud_search" | "cloud_get");
    for block in shader.blocks() {
        block.walk(&mut |s| {
            let (args, span) = match s {
                Stmt::Let(id) => match &shader.values[id.0 as usize] {
                    Value { inst: Inst::Call(func, args), span, .. } if asks(*func) => (args, *span),
                    _ => return,
                },
                Stmt::Call { func, args, span, .. } if asks(*func) => (args, *span),
                _ => return,
            };
            if let Some(Arg::Value(file)) = args.first() {
                calls.push((*file, span));
            }
        });
    }
    let strings = Strings::of(shader);
    let mut names = BTreeSet::new();
    for (file, span) in calls {
        match strings.trace(shader, vec![file], Vec::new()) {
            Some(files) => names.extend(files),
            None => {
                let d = Diagnostic::not_yet("E3003", span, "a point cloud whose name is not known at compile time");
                return Err(vec![d.help("choose among constants, by parameters or conditions")]);
            }
        }
    }
    Ok(names.into_iter().filter(|n| !n.is_empty()).collect())
}

/// Carries out `cloud_write`; what is to be said about it is returned.
pub(super) fn answer(shader: &mut Shader, rays: Rays) -> Vec<Diagnostic> {
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| {
            found |= matches!(s, Stmt::Call { func, .. } if builtins::row(*func).name == "cloud_write");
        });
    }
    let mut writes = Writes { shader, writes: rays == Rays::Pretended, warnings: Vec::new() };
    if found {
        writes.rewrite();
    }
    writes.warnings
}

struct Writes<'a> {
    shader: &'a mut Shader,
    writes: bool,
    warnings: Vec<Diagnostic>,
}

impl Rewriter for Writes<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Call { func, args, result, span, .. } if builtins::row(func).name == "cloud_write" => {
                let (Some(result), Some(Arg::Value(file))) = (result, args.first()) else { return };
                let value = if self.writes {
                    let none = self.shader.emit_constant(Const::Str(String::new()), span, out);
                    self.shader.emit(Inst::Binary(BinaryOp::Ne, *file, none), Ty::Int, span, out)
                } else {
                    let message = "`pointcloud_write` writes nothing in renders, and is 0";
                    let d = Diagnostic::warning("W3003", span, message);
                    add(&mut self.warnings, d.help("`oslcl testshade` and `oslcl shade` write point clouds"));
                    self.shader.emit_constant(Const::Int(0), span, out)
                };
                out.stmts.push(Stmt::Store(result, value));
            }
            other => out.stmts.push(other),
        }
    }
}
