//! Reads the text that [`super::print`] writes. For tests and tools; the compiler itself never needs it.

use super::{
    Arg, BinaryOp, Block, Const, Global, Input, Inst, LobeSlot, Local, LocalId, LocalKind, Loop, Param, Shader,
    SlotArg, Source, Stmt, Traits, Ty, UnaryOp, Value, ValueId,
};
use crate::builtins;
use crate::source::{FileId, Span};
use crate::types::{Base, Extent, Type};

/// Why a text is no shader.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct ReadError {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

/// Reads one shader. The result is not verified; spans are empty.
pub fn read(text: &str) -> Result<Shader, ReadError> {
    let tokens = tokenise(text)?;
    let mut r = Reader { tokens, at: 0, values: Vec::new() };
    let mut shader = Shader {
        kind: r.word()?,
        name: r.string()?,
        params: Vec::new(),
        locals: Vec::new(),
        values: Vec::new(),
        body: Block::default(),
        slots: Vec::new(),
        inputs: Vec::new(),
        derivative_uses: Vec::new(),
    };
    loop {
        match r.word()?.as_str() {
            "local" => shader.locals.push(r.local()?),
            "input" => {
                let input = r.input()?;
                shader.inputs.push(input);
            }
            "param" => {
                let param = r.param(&shader.locals)?;
                shader.params.push(param);
            }
            "slot" => shader.slots.push(r.slot()?),
            "body" => break,
            other => return Err(r.error(format!("`{other}` is unexpected"))),
        }
    }
    shader.body = r.block()?;
    let none = Value { inst: Inst::Const(Const::Int(0)), ty: Ty::Int, span: NOWHERE };
    shader.values = r.values.into_iter().map(|v| v.unwrap_or_else(|| none.clone())).collect();
    Ok(shader)
}

const NOWHERE: Span = Span { file: FileId(0), start: 0, end: 0 };

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Str(String),
    Punct(char),
}

fn tokenise(text: &str) -> Result<Vec<(usize, Token)>, ReadError> {
    let mut out = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let number = i + 1;
        let mut chars = line.char_indices().peekable();
        while let Some((start, c)) = chars.next() {
            let token = match c {
                ' ' | '\t' => continue,
                '"' => {
                    let mut escaped = false;
                    let end = loop {
                        match chars.next() {
                            Some((_, '\\')) if !escaped => escaped = true,
                            Some((end, '"')) if !escaped => break end,
                            Some(_) => escaped = false,
                            None => return Err(ReadError { line: number, message: "a string is not closed".into() }),
                        }
                    };
                    Token::Str(unescape(&line[start + 1..end]))
                }
                '(' | ')' | '{' | '}' | '[' | ']' | ',' | '=' | ':' => Token::Punct(c),
                _ => {
                    let mut end = start + c.len_utf8();
                    while let Some((at, c)) = chars.peek().copied() {
                        if c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '+' | '#' | '>') {
                            end = at + c.len_utf8();
                            chars.next();
                        } else {
                            break;
                        }
                    }
                    Token::Word(line[start..end].to_string())
                }
            };
            out.push((number, token));
        }
    }
    Ok(out)
}

/// Undoes Rust's `{:?}` of strings.
fn unescape(text: &str) -> String {
    let mut out = String::new();
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        if c != '\\' {
            out.push(c);
            continue;
        }
        match chars.next() {
            Some('n') => out.push('\n'),
            Some('t') => out.push('\t'),
            Some('r') => out.push('\r'),
            Some('0') => out.push('\0'),
            Some('u') => {
                let hex: String = chars.by_ref().skip(1).take_while(|c| *c != '}').collect();
                out.extend(u32::from_str_radix(&hex, 16).ok().and_then(char::from_u32));
            }
            Some(other) => out.push(other),
            None => {}
        }
    }
    out
}

struct Reader {
    tokens: Vec<(usize, Token)>,
    at: usize,
    values: Vec<Option<Value>>,
}

type Read<T> = Result<T, ReadError>;

impl Reader {
    fn error(&self, message: impl Into<String>) -> ReadError {
        let line = self.tokens.get(self.at.saturating_sub(1)).map_or(1, |t| t.0);
        ReadError { line, message: message.into() }
    }

    fn next(&mut self) -> Read<Token> {
        let token = self.tokens.get(self.at).map(|t| t.1.clone());
        self.at += 1;
        token.ok_or_else(|| self.error("the text ends too early"))
    }

    fn take(&mut self, c: char) -> bool {
        let found = matches!(self.tokens.get(self.at), Some((_, Token::Punct(p))) if *p == c);
        self.at += found as usize;
        found
    }

    fn take_word(&mut self, word: &str) -> bool {
        let found = matches!(self.tokens.get(self.at), Some((_, Token::Word(w))) if w == word);
        self.at += found as usize;
        found
    }

    fn punct(&mut self, c: char) -> Read<()> {
        if self.take(c) {
            Ok(())
        } else {
            self.at += 1;
            Err(self.error(format!("expected `{c}`")))
        }
    }

    fn word(&mut self) -> Read<String> {
        match self.next()? {
            Token::Word(w) => Ok(w),
            other => Err(self.error(format!("expected a word, found {other:?}"))),
        }
    }

    fn string(&mut self) -> Read<String> {
        match self.next()? {
            Token::Str(s) => Ok(s),
            other => Err(self.error(format!("expected a string, found {other:?}"))),
        }
    }

    fn number<T: std::str::FromStr>(&mut self) -> Read<T> {
        let word = self.word()?;
        word.parse().map_err(|_| self.error(format!("`{word}` is no number here")))
    }

    fn handle(&mut self, letter: char) -> Read<u32> {
        let word = self.word()?;
        let id = word.strip_prefix(letter).and_then(|n| n.parse().ok());
        id.ok_or_else(|| self.error(format!("expected {letter} and a number, found `{word}`")))
    }

    fn local_id(&mut self) -> Read<LocalId> {
        self.handle('L').map(LocalId)
    }

    fn value_id(&mut self) -> Read<ValueId> {
        self.handle('%').map(ValueId)
    }

    fn ty(&mut self) -> Read<Ty> {
        let word = self.word()?;
        Ok(match word.as_str() {
            "i" => Ty::Int,
            "f" => Ty::Float,
            "v" => Ty::Triple,
            "m" => Ty::Matrix,
            "s" => Ty::Str,
            "c" => Ty::Closure,
            _ => return Err(self.error(format!("`{word}` is no type"))),
        })
    }

    fn len(&mut self) -> Read<Option<u32>> {
        if !self.take('[') {
            return Ok(None);
        }
        let n = self.number()?;
        self.punct(']')?;
        Ok(Some(n))
    }

    fn local(&mut self) -> Read<Local> {
        self.local_id()?;
        let ty = self.ty()?;
        let len = self.len()?;
        let name = self.string()?;
        let kind = match self.take_word("is") {
            false => LocalKind::Variable,
            true if self.take_word("param") => LocalKind::Param(self.number()?),
            true if self.take_word("input") => LocalKind::Input(self.number()?),
            true => {
                self.word()?;
                let word = self.word()?;
                let global = Global::ALL.into_iter().find(|g| g.name() == word);
                LocalKind::Global(global.ok_or_else(|| self.error(format!("`{word}` is no global")))?)
            }
        };
        Ok(Local { name, ty, len, kind })
    }

    fn base(&mut self) -> Read<Base> {
        let keyword = self.string()?;
        const BASES: [Base; 9] = [
            Base::Int,
            Base::Float,
            Base::Color,
            Base::Point,
            Base::Vector,
            Base::Normal,
            Base::Matrix,
            Base::String,
            Base::Closure,
        ];
        let base = BASES.into_iter().find(|b| b.keyword() == keyword);
        let base = base.ok_or_else(|| self.error(format!("`{keyword}` is no type")))?;
        Ok(base)
    }

    fn input(&mut self) -> Read<Input> {
        use Source::*;
        let word = self.word()?;
        let source = [Userdata, HasUserdata, Interactive, HasInteractive].into_iter().find(|s| s.name() == word);
        let source = source.ok_or_else(|| self.error(format!("`{word}` is no source of inputs")))?;
        let ty = self.ty()?;
        let len = self.len()?;
        let base = self.base()?;
        let name = self.string()?;
        let constants = ["i", "f", "v", "m", "s", "a"];
        let default = match self.tokens.get(self.at) {
            Some((_, Token::Word(w))) if constants.contains(&w.as_str()) => Some(self.constant()?),
            _ => None,
        };
        let declared = Type { base, extent: len.map_or(Extent::Scalar, Extent::Fixed) };
        Ok(Input { name, source, declared, ty, len, default })
    }

    fn param(&mut self, locals: &[Local]) -> Read<Param> {
        let local = self.local_id()?;
        let base = self.base()?;
        let name = self.string()?;
        let output = self.take_word("output");
        let varying = self.take_word("varying");
        let traits = Traits {
            interactive: self.take_word("interactive"),
            unconnectable: self.take_word("unconnectable"),
            open: self.take_word("open"),
        };
        let init = self.block()?;
        let len = locals.get(local.0 as usize).and_then(|l| l.len);
        let declared = Type { base, extent: len.map_or(Extent::Scalar, Extent::Fixed) };
        Ok(Param { name, declared, output, local, varying, init, span: NOWHERE, traits })
    }

    fn closure_id(&mut self) -> Read<builtins::ClosureId> {
        let word = self.word()?;
        let id = word.split_once('#').and_then(|(_, n)| n.parse::<u16>().ok());
        match id {
            Some(n) if (n as usize) < builtins::CLOSURES.len() => Ok(builtins::ClosureId(n)),
            _ => Err(self.error(format!("`{word}` is no closure"))),
        }
    }

    fn slot(&mut self) -> Read<LobeSlot> {
        let closure = self.closure_id()?;
        let weight = self.local_id()?;
        self.punct('(')?;
        let mut args = Vec::new();
        while !self.take(')') {
            let local = matches!(self.tokens.get(self.at), Some((_, Token::Word(w))) if w.starts_with('L'));
            args.push(if local { SlotArg::Local(self.local_id()?) } else { SlotArg::Const(self.constant()?) });
            self.take(',');
        }
        Ok(LobeSlot { closure, weight, args, span: NOWHERE })
    }

    fn constant(&mut self) -> Read<Const> {
        let letter = self.word()?;
        self.constant_of(&letter)
    }

    fn floats<const N: usize>(&mut self) -> Read<[f64; N]> {
        let mut out = [0.0; N];
        self.punct('(')?;
        for x in &mut out {
            *x = self.number()?;
        }
        self.punct(')')?;
        Ok(out)
    }

    fn constant_of(&mut self, letter: &str) -> Read<Const> {
        Ok(match letter {
            "i" => Const::Int(self.number()?),
            "f" => Const::Float(self.number()?),
            "v" => Const::Triple(self.floats()?),
            "m" => Const::Matrix(self.floats()?),
            "s" => Const::Str(self.string()?),
            "a" => {
                self.punct('(')?;
                let mut items = Vec::new();
                while !self.take(')') {
                    items.push(self.constant()?);
                }
                Const::Array(items)
            }
            other => return Err(self.error(format!("`{other}` is no constant"))),
        })
    }

    fn block(&mut self) -> Read<Block> {
        self.punct('{')?;
        let mut block = Block::default();
        while !self.take('}') {
            let stmt = self.stmt()?;
            block.stmts.push(stmt);
        }
        Ok(block)
    }

    fn stmt(&mut self) -> Read<Stmt> {
        let word = self.word()?;
        Ok(match word.as_str() {
            "store" => Stmt::Store(self.local_id()?, self.value_id()?),
            "storeelem" => Stmt::StoreElem(self.local_id()?, self.value_id()?, self.value_id()?),
            "copy" => Stmt::CopyArray(self.local_id()?, self.local_id()?),
            "break" => Stmt::Break,
            "continue" => Stmt::Continue,
            "call" => {
                let (func, args) = self.call()?;
                if !self.take_word("->") {
                    return Err(self.error("expected `->`"));
                }
                self.punct('(')?;
                let mut outputs = Vec::new();
                while !self.take(')') {
                    outputs.push(self.local_id()?);
                    self.take(',');
                }
                let result = if self.take_word("result") { Some(self.local_id()?) } else { None };
                Stmt::Call { func, args, outputs, result, span: NOWHERE }
            }
            "if" => {
                let cond = self.value_id()?;
                let then = self.block()?;
                let otherwise = if self.take_word("else") { self.block()? } else { Block::default() };
                Stmt::If(cond, then, otherwise)
            }
            "loop" => {
                let head = self.block()?;
                self.word()?;
                let cond = self.value_id()?;
                let tested_after = self.take_word("after");
                let body = self.block()?;
                self.word()?;
                let step = self.block()?;
                Stmt::Loop(Box::new(Loop { head, cond, tested_after, body, step }))
            }
            word => {
                let id = word.strip_prefix('%').and_then(|n| n.parse::<u32>().ok()).filter(|n| *n < 100_000_000);
                let id = id.ok_or_else(|| self.error(format!("`{word}` is no statement")))?;
                self.punct(':')?;
                let ty = self.ty()?;
                self.punct('=')?;
                let inst = self.inst()?;
                if self.values.len() <= id as usize {
                    self.values.resize(id as usize + 1, None);
                }
                self.values[id as usize] = Some(Value { inst, ty, span: NOWHERE });
                Stmt::Let(ValueId(id))
            }
        })
    }

    fn call(&mut self) -> Read<(builtins::FuncId, Vec<Arg>)> {
        let name = self.word()?;
        let func = builtins::find(&name).ok_or_else(|| self.error(format!("`{name}` is no built-in")))?;
        self.punct('(')?;
        let mut args = Vec::new();
        while !self.take(')') {
            let local = matches!(self.tokens.get(self.at), Some((_, Token::Word(w))) if w.starts_with('L'));
            args.push(if local { Arg::Array(self.local_id()?) } else { Arg::Value(self.value_id()?) });
            self.take(',');
        }
        Ok((func, args))
    }

    fn values_here(&mut self) -> Read<Vec<ValueId>> {
        let mut out = Vec::new();
        // Operands stand on the line of their instruction, and a statement `%n:` starts a new one.
        while let Some((_, Token::Word(w))) = self.tokens.get(self.at) {
            let starts_stmt = matches!(self.tokens.get(self.at + 1), Some((_, Token::Punct(':'))));
            if !w.starts_with('%') || starts_stmt {
                break;
            }
            out.push(self.value_id()?);
        }
        Ok(out)
    }

    fn exactly<const N: usize>(&mut self) -> Read<[ValueId; N]> {
        let mut out = [ValueId(0); N];
        for v in &mut out {
            *v = self.value_id()?;
        }
        Ok(out)
    }

    fn inst(&mut self) -> Read<Inst> {
        use BinaryOp::*;
        let word = self.word()?;
        let binary = [Add, Sub, Mul, Div, Mod, Eq, Ne, Lt, Le, Gt, Ge, BitAnd, BitOr, BitXor, Shl, Shr]
            .into_iter()
            .find(|op| format!("{op:?}").to_lowercase() == word);
        if let Some(op) = binary {
            let [a, b] = self.exactly()?;
            return Ok(Inst::Binary(op, a, b));
        }
        Ok(match word.as_str() {
            "load" => Inst::Load(self.local_id()?),
            "loadelem" => Inst::LoadElem(self.local_id()?, self.value_id()?),
            "neg" => Inst::Unary(UnaryOp::Neg, self.value_id()?),
            "compl" => Inst::Unary(UnaryOp::Compl, self.value_id()?),
            "not" => Inst::Unary(UnaryOp::Not, self.value_id()?),
            "convert" => Inst::Convert(self.value_id()?),
            "triple" => Inst::Triple(self.exactly()?),
            "matrix" => Inst::Matrix(Box::new(self.exactly()?)),
            "component" => Inst::Component(self.value_id()?, self.value_id()?),
            "element" => Inst::MatrixElement(self.value_id()?, self.value_id()?, self.value_id()?),
            "withcomponent" => Inst::WithComponent(self.value_id()?, self.value_id()?, self.value_id()?),
            "withelement" => {
                let [a, b, c, d] = self.exactly()?;
                Inst::WithMatrixElement(a, b, c, d)
            }
            "select" => Inst::Select(self.value_id()?, self.value_id()?, self.value_id()?),
            "call" => {
                let (func, args) = self.call()?;
                Inst::Call(func, args)
            }
            "closure" => Inst::Closure(self.closure_id()?, self.values_here()?),
            "albedo" => Inst::Albedo(self.closure_id()?, self.values_here()?),
            "layer" => Inst::Layer(self.value_id()?, self.value_id()?),
            "null" => Inst::NullClosure,
            "addclosure" => Inst::AddClosure(self.value_id()?, self.value_id()?),
            "scaleclosure" => Inst::ScaleClosure(self.value_id()?, self.value_id()?),
            "isset" => Inst::ClosureIsSet(self.value_id()?),
            letter => Inst::Const(self.constant_of(letter)?),
        })
    }
}
