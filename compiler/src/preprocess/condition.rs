//! The integer expressions of `#if` and `#elif` (C11 6.10.1), after macro expansion.

use super::lexer::{Kind, Token};

/// The value, or what is wrong in the user's words. `&&`, `||` and `?:` do not complain of a division by zero in the
/// part that does not count.
pub(super) fn evaluate(tokens: &[Token]) -> Result<i64, String> {
    let mut parser = Parser { tokens, at: 0, depth: 0 };
    let value = parser.ternary()?;
    match parser.tokens.get(parser.at) {
        None => value.ok_or_else(|| "division by zero".to_string()),
        Some(t) => Err(format!("`{}` is unexpected here", t.str())),
    }
}

/// `None`: undefined (division by zero), an error only when it counts.
type Value = Option<i64>;

struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    depth: u32,
}

/// Binary operators by rising precedence.
const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<", "<=", ">", ">="],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

impl Parser<'_> {
    fn take(&mut self, punct: &str) -> bool {
        let found = self.tokens.get(self.at).is_some_and(|t| t.is(punct));
        self.at += found as usize;
        found
    }

    fn ternary(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > 200 {
            return Err("the expression is nested too deeply".into());
        }
        let cond = self.binary(0)?;
        let value = if self.take("?") {
            let then = self.ternary()?;
            if !self.take(":") {
                return Err("expected `:`".into());
            }
            let otherwise = self.ternary()?;
            cond.and_then(|c| if c != 0 { then } else { otherwise })
        } else {
            cond
        };
        self.depth -= 1;
        Ok(value)
    }

    fn binary(&mut self, level: usize) -> Result<Value, String> {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        while let Some(op) = operators.iter().find(|op| self.take(op)) {
            let right = self.binary(level + 1)?;
            left = apply(op, left, right);
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > 200 {
            return Err("the expression is nested too deeply".into());
        }
        let value = self.unary_inner();
        self.depth -= 1;
        value
    }

    fn unary_inner(&mut self) -> Result<Value, String> {
        if self.take("!") {
            return Ok(self.unary()?.map(|v| (v == 0) as i64));
        }
        if self.take("-") {
            return Ok(self.unary()?.map(i64::wrapping_neg));
        }
        if self.take("+") {
            return self.unary();
        }
        if self.take("~") {
            return Ok(self.unary()?.map(|v| !v));
        }
        if self.take("(") {
            let value = self.ternary()?;
            return if self.take(")") { Ok(value) } else { Err("expected `)`".into()) };
        }
        let Some(token) = self.tokens.get(self.at) else { return Err("an expression is missing".into()) };
        self.at += 1;
        match token.kind {
            Kind::Char => character(token.str()).map(Some),
            // A name that is no macro counts as 0 (C11 6.10.1, paragraph 4).
            Kind::Ident => Ok(Some(0)),
            Kind::Number => integer(token.str()).map(Some),
            _ => Err(format!("`{}` is unexpected here", token.str())),
        }
    }
}

/// The value of `'a'`. Only `#if` has character constants.
fn character(text: &str) -> Result<i64, String> {
    let inner = text.strip_prefix('\'').and_then(|t| t.strip_suffix('\'')).unwrap_or("");
    let mut letters = inner.chars();
    let value = match (letters.next(), letters.next(), letters.next()) {
        (Some('\\'), Some(c), None) => match c {
            'n' => Some('\n'),
            't' => Some('\t'),
            'r' => Some('\r'),
            '0' => Some('\0'),
            other => Some(other),
        },
        (Some(c), None, None) => Some(c),
        _ => None,
    };
    value.map(|c| c as i64).ok_or_else(|| format!("{text} is not a character"))
}

fn integer(text: &str) -> Result<i64, String> {
    let digits = text.trim_end_matches(['u', 'U', 'l', 'L']);
    let value = match digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
        Some(hex) => i64::from_str_radix(hex, 16),
        None if digits.len() > 1 && digits.starts_with('0') => i64::from_str_radix(digits, 8),
        None => digits.parse(),
    };
    value.map_err(|_| format!("`{text}` is not an integer"))
}

fn apply(op: &str, left: Value, right: Value) -> Value {
    // Short circuits first: they don't need the right side.
    match (op, left) {
        ("&&", Some(0)) => return Some(0),
        ("||", Some(l)) if l != 0 => return Some(1),
        _ => {}
    }
    let (l, r) = (left?, right?);
    Some(match op {
        "||" | "&&" => (r != 0) as i64,
        "|" => l | r,
        "^" => l ^ r,
        "&" => l & r,
        "==" => (l == r) as i64,
        "!=" => (l != r) as i64,
        "<" => (l < r) as i64,
        "<=" => (l <= r) as i64,
        ">" => (l > r) as i64,
        ">=" => (l >= r) as i64,
        "<<" => l.wrapping_shl(r as u32),
        ">>" => l.wrapping_shr(r as u32),
        "+" => l.wrapping_add(r),
        "-" => l.wrapping_sub(r),
        "*" => l.wrapping_mul(r),
        "/" => return l.checked_div(r),
        _ => return l.checked_rem(r),
    })
}
