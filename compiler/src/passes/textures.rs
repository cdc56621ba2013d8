//! Texture files that a shader can ask for, and answers of `gettextureinfo`.
//!
//! In: folded IR. Out: the same without `textureinfo` calls: each becomes the stores of its answer, behind comparisons
//! where the file, the kind of information or the tile of a set is chosen while the shader runs. [`textures`] lists the
//! files that are left.

use super::strings::Strings;
use crate::builtins;
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, LocalId, Rewriter, Shader, Stmt, Ty, ValueId};
use crate::messages;
use crate::source::Span;
use crate::textures::{Info, InfoType, Kind, TextureAccess, Textures};
use std::collections::BTreeMap;

/// Most answers that one call may choose among.
const MAX_ANSWERS: usize = 4096;

/// How a shader uses a texture file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct TextureUse {
    /// Its name as the shader has it.
    pub file: String,
    /// The functions that look it up, sorted, each once.
    pub kinds: Vec<Kind>,
    /// Channels that are asked for at most; `None` when only running the shader tells.
    pub channels: Option<u32>,
    /// Interpolations that occur, by name, sorted.
    #[serde(deserialize_with = "known::interps")]
    pub interps: Vec<&'static str>,
    /// Some lookup neither says what stands in for a missing file nor asks for the message.
    pub must_exist: bool,
}

/// Names that are the compiler's own, read back.
mod known {
    use crate::textures::INTERPS;
    use serde::de::{Deserialize, Deserializer, Error};

    pub fn interps<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<&'static str>, D::Error> {
        let own = |name: &String| INTERPS.into_iter().find(|own| own == name);
        let names = Vec::<String>::deserialize(from)?;
        let unknown = || D::Error::custom(format!("an interpolation is none of {INTERPS:?}: {names:?}"));
        names.iter().map(own).collect::<Option<_>>().ok_or_else(unknown)
    }
}

/// Whether a built-in is a lookup, and of which kind.
fn lookup_kind(func: builtins::FuncId) -> Option<Kind> {
    Some(match builtins::row(func).name {
        "texture_lookup" | "texture_ds" | "texture_dt" | "texture_error" => Kind::Texture,
        "texture3d_lookup" | "texture3d_ds" | "texture3d_dt" | "texture3d_dr" => Kind::Volume,
        "environment_lookup" => Kind::Environment,
        _ => return None,
    })
}

/// Whether a built-in looks a texture up.
pub(crate) fn is_lookup(func: builtins::FuncId) -> bool {
    lookup_kind(func).is_some()
}

/// Where the mode stands among a lookup's arguments; the first channel follows it.
fn mode_place(func: builtins::FuncId) -> Option<usize> {
    match builtins::row(func).name {
        "texture_error" => None,
        "environment_lookup" => Some(4),
        name if name.starts_with("texture3d") => Some(2),
        _ => Some(7),
    }
}

/// The texture files that a shader can ask for, by name. A name that is not one of a known set is an error.
pub fn textures(shader: &Shader) -> Result<Vec<TextureUse>, Vec<Diagnostic>> {
    let mut calls = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Let(id) = s
                && let Inst::Call(func, args) = &shader.values[id.0 as usize].inst
                && let (Some(kind), Some(Arg::Value(file))) = (lookup_kind(*func), args.first())
            {
                calls.push((*id, *func, kind, *file));
            }
        });
    }
    if calls.is_empty() {
        return Ok(Vec::new());
    }
    let strings = Strings::of(shader);
    let mut found: BTreeMap<String, TextureUse> = BTreeMap::new();
    let mut errors = Vec::new();
    for (id, func, kind, file) in calls {
        let value = &shader.values[id.0 as usize];
        let Some(files) = strings.trace(shader, vec![file], Vec::new()) else {
            errors.push(unknown(value.span));
            continue;
        };
        let Inst::Call(_, args) = &value.inst else { continue };
        let (interps, channels, must_exist) = details(shader, func, args, value.ty);
        for file in files {
            let entry = found.entry(file.clone()).or_insert_with(|| TextureUse {
                file,
                kinds: Vec::new(),
                channels: Some(0),
                interps: Vec::new(),
                must_exist: false,
            });
            entry.must_exist |= must_exist;
            entry.kinds.push(kind);
            entry.kinds.sort();
            entry.kinds.dedup();
            entry.interps.extend(&interps);
            entry.interps.sort_unstable();
            entry.interps.dedup();
            entry.channels = entry.channels.zip(channels).map(|(a, b)| a.max(b));
        }
    }
    errors.dedup();
    if errors.is_empty() { Ok(found.into_values().collect()) } else { Err(errors) }
}

fn unknown(span: Span) -> Diagnostic {
    Diagnostic::not_yet("E3003", span, "a texture's file name that is not known at compile time")
        .help("choose among constants, by parameters or conditions")
}

/// Interpolations, the number of channels and whether the file must be there, as far as constants tell.
fn details(shader: &Shader, func: builtins::FuncId, args: &[Arg], ty: Ty) -> (Vec<&'static str>, Option<u32>, bool) {
    use crate::textures::{INTERPS, MODE_INTERP, MODE_MISSING, MODE_QUIET};
    let Some(at) = mode_place(func) else { return (Vec::new(), Some(0), false) };
    let constant = |i: usize| match args.get(i) {
        Some(Arg::Value(v)) => match &shader.values[v.0 as usize].inst {
            Inst::Const(Const::Int(n)) => Some(*n),
            _ => None,
        },
        _ => None,
    };
    let interps = match constant(at) {
        Some(mode) => vec![INTERPS[((mode / MODE_INTERP) & 3) as usize]],
        None => INTERPS.to_vec(),
    };
    let width = if ty == Ty::Triple { 3 } else { 1 };
    let must_exist = constant(at).is_some_and(|mode| mode & (MODE_MISSING | MODE_QUIET) == 0);
    (interps, constant(at + 1).map(|first| (first.max(0) as u32).saturating_add(width)), must_exist)
}

/// Replaces every `textureinfo` call by its answer.
pub(super) fn answer(shader: &mut Shader, access: Option<&TextureAccess>) -> Result<(), Vec<Diagnostic>> {
    let Some(func) = builtins::find("textureinfo") else { return Ok(()) };
    let mut asks = false;
    for block in shader.blocks() {
        block.walk(&mut |s| asks |= matches!(s, Stmt::Call { func: f, .. } if *f == func));
    }
    if !asks {
        return Ok(());
    }
    let strings = Strings::of(shader);
    let mut pass = Pass { func, strings, access: access.map(|a| &*a.0), shader, errors: Vec::new() };
    pass.rewrite();
    let errors = pass.errors;
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

struct Pass<'a> {
    func: builtins::FuncId,
    strings: Strings,
    access: Option<&'a dyn Textures>,
    shader: &'a mut Shader,
    errors: Vec<Diagnostic>,
}

/// One call.
struct Ask<'a> {
    file: ValueId,
    st: [ValueId; 2],
    st_given: bool,
    name: ValueId,
    output: LocalId,
    result: Option<LocalId>,
    span: Span,
    access: &'a dyn Textures,
}

impl Rewriter for Pass<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Call { func, args, outputs, result, span } if func == self.func => {
                self.call(&args, &outputs, result, span, out);
            }
            other => out.stmts.push(other),
        }
    }
}

impl Pass<'_> {
    fn error(&mut self, d: Diagnostic) {
        if self.errors.len() < 100 && !self.errors.contains(&d) {
            self.errors.push(d);
        }
    }

    fn int(&mut self, v: i32, span: Span, out: &mut Block) -> ValueId {
        self.shader.emit_constant(Const::Int(v), span, out)
    }

    fn call(&mut self, args: &[Arg], outputs: &[LocalId], result: Option<LocalId>, span: Span, out: &mut Block) {
        let value = |i: usize| match args.get(i) {
            Some(Arg::Value(v)) => Some(*v),
            _ => None,
        };
        let (Some(file), Some(s), Some(t), Some(given), Some(name), Some(output)) =
            (value(0), value(1), value(2), value(3), value(4), outputs.first().copied())
        else {
            return;
        };
        let Some(access) = self.access else {
            let what = "`gettextureinfo` where nothing reads texture files";
            return self.error(Diagnostic::not_yet("E3001", span, what).help("render or shade with it"));
        };
        let st_given = matches!(&self.shader.values[given.0 as usize].inst, Inst::Const(Const::Int(1)));
        let ask = Ask { file, st: [s, t], st_given, name, output, result, span, access };
        let Some(files) = self.strings.trace(self.shader, vec![file], Vec::new()) else {
            return self.error(unknown(span));
        };
        let Some(names) = self.strings.trace(self.shader, vec![name], Vec::new()) else {
            let what = "information about a texture whose name is not known at compile time";
            return self.error(
                Diagnostic::not_yet("E3003", span, what).help("choose among constants, by parameters or conditions"),
            );
        };
        if files.len() * names.len() > MAX_ANSWERS {
            let what = format!("`gettextureinfo` with more than {MAX_ANSWERS} possible answers");
            return self.error(Diagnostic::not_yet("E3005", span, what));
        }
        if let Some(result) = result {
            let zero = self.int(0, span, out);
            out.stmts.push(Stmt::Store(result, zero));
        }
        let pairs: Vec<(&String, &String)> = files.iter().flat_map(|f| names.iter().map(move |n| (f, n))).collect();
        let certain = pairs.len() == 1;
        for (file, name) in pairs {
            let mut inner = Block::default();
            self.answer_of(&ask, file, name, &mut inner);
            if certain {
                out.stmts.extend(inner.stmts);
                continue;
            }
            let mut conditions = Vec::new();
            for (given, text, several) in [(ask.file, file, files.len() > 1), (ask.name, name, names.len() > 1)] {
                if several {
                    let text = self.shader.emit_constant(Const::Str(text.clone()), span, out);
                    conditions.push(self.shader.emit(Inst::Binary(BinaryOp::Eq, given, text), Ty::Int, span, out));
                }
            }
            self.under(&conditions, inner, span, out);
        }
    }

    /// Statements that run when all conditions hold.
    fn under(&mut self, conditions: &[ValueId], inner: Block, span: Span, out: &mut Block) {
        let Some((first, rest)) = conditions.split_first() else { return out.stmts.extend(inner.stmts) };
        if inner.stmts.is_empty() {
            return;
        }
        let mut all = *first;
        for other in rest {
            all = self.shader.emit(Inst::Binary(BinaryOp::BitAnd, all, *other), Ty::Int, span, out);
        }
        out.stmts.push(Stmt::If(all, inner, Block::default()));
    }

    /// The stores of one file's answer; none when it does not know.
    fn answer_of(&mut self, ask: &Ask<'_>, file: &str, name: &str, out: &mut Block) {
        let tiles = ask.access.tiles(file).filter(|_| ask.st_given);
        let Some((columns, rows)) = tiles else { return self.stores(ask, file, None, name, out) };
        if columns as usize * rows as usize > MAX_ANSWERS {
            let what = format!("`gettextureinfo` of a set of {columns} x {rows} textures");
            return self.error(Diagnostic::not_yet("E3005", ask.span, what));
        }
        let span = ask.span;
        // Towards zero: what lies a little before the first tile counts to it, as in the reference.
        let place = ask.st.map(|c| self.shader.emit(Inst::Convert(c), Ty::Int, span, out));
        for tile in (0..rows).flat_map(|v| (0..columns).map(move |u| (u, v))) {
            let mut inner = Block::default();
            self.stores(ask, file, Some(tile), name, &mut inner);
            if inner.stmts.is_empty() {
                continue;
            }
            let mut conditions = Vec::new();
            for (place, number) in place.iter().zip([tile.0, tile.1]) {
                let number_value = self.int(number as i32, span, out);
                // The first column and row take all that lies before them.
                let op = if number == 0 { BinaryOp::Le } else { BinaryOp::Eq };
                conditions.push(self.shader.emit(Inst::Binary(op, *place, number_value), Ty::Int, span, out));
            }
            self.under(&conditions, inner, span, out);
        }
    }

    /// What the reference says when the file of a question cannot be read.
    fn say_missing(&mut self, ask: &Ask<'_>, file: &str, out: &mut Block) {
        if ask.access.tiles(file).is_some() {
            return;
        }
        let cause = ask.access.error(file, [0.0; 2], 0, "");
        let Some(func) = builtins::find("print").filter(|_| !cause.is_empty()) else { return };
        let text = format!("[RendererServices::get_texture_info] Invalid image file \"{file}\": {cause}");
        let mut args = vec![Arg::Value(self.int(messages::code::ERROR, ask.span, out))];
        for text in [String::new(), "%s".to_owned(), text] {
            let value = self.shader.emit_constant(Const::Str(text), ask.span, out);
            args.push(Arg::Value(value));
        }
        out.stmts.push(Stmt::Call { func, args, outputs: Vec::new(), result: None, span: ask.span });
    }

    fn stores(&mut self, ask: &Ask<'_>, file: &str, tile: Option<(u32, u32)>, name: &str, out: &mut Block) {
        let local = &self.shader.locals[ask.output.0 as usize];
        let (ty, len, span) = (local.ty, local.len, ask.span);
        let (kind, width) = match ty {
            Ty::Int => (InfoType::Int, 1),
            Ty::Float => (InfoType::Float, 1),
            Ty::Triple => (InfoType::Float, 3),
            Ty::Matrix => (InfoType::Float, 16),
            _ => (InfoType::Text, 1),
        };
        let count = width * len.unwrap_or(1) as usize;
        let Some(info) = ask.access.info(file, tile, name, kind, count) else {
            return self.say_missing(ask, file, out);
        };
        let constants: Vec<Const> = match (info, ty) {
            (Info::Ints(v), Ty::Int) => v.into_iter().map(Const::Int).collect(),
            (Info::Floats(v), Ty::Float) => v.into_iter().map(Const::Float).collect(),
            (Info::Floats(v), Ty::Triple) => v.chunks_exact(3).map(|c| Const::Triple([c[0], c[1], c[2]])).collect(),
            (Info::Floats(v), Ty::Matrix) => v
                .chunks_exact(16)
                .map(|c| {
                    let mut m = [0.0; 16];
                    m.copy_from_slice(c);
                    Const::Matrix(m)
                })
                .collect(),
            (Info::Text(s), Ty::Str) => vec![Const::Str(s)],
            // Whoever answers gave another type than was asked for: as good as no answer.
            _ => return,
        };
        for (i, c) in constants.into_iter().enumerate() {
            let value = self.shader.emit(Inst::Const(c), ty, span, out);
            match len {
                None => out.stmts.push(Stmt::Store(ask.output, value)),
                Some(_) => {
                    let index = self.int(i as i32, span, out);
                    out.stmts.push(Stmt::StoreElem(ask.output, index, value));
                }
            }
        }
        if let Some(result) = ask.result {
            let one = self.int(1, span, out);
            out.stmts.push(Stmt::Store(result, one));
        }
    }
}
