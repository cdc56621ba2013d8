//! OSL's string functions (specification ch. 7.8) on constants: strings are ids on the device, so that only the host can
//! look into them.
//!
//! In: a row's name and its arguments. Out: the value; `None` when the row is none of these or the arguments do not fit.
//! Positions and lengths count bytes, as in OSL.

use crate::ir::Const;
use crate::strings::string_id;

/// Longest string that folding makes: concatenation in a loop doubles.
const MAX_BYTES: usize = 1 << 16;

/// Largest width and precision that a format may ask for.
const MAX_WIDTH: usize = 256;

/// The value of a call.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    use Const::{Float, Int, Str};
    let value = match (name, args) {
        ("hash_string", [Str(s)]) => Int(string_id(s) as i32),
        ("strlen", [Str(s)]) => Int(i32::try_from(s.len()).ok()?),
        ("startswith", [Str(s), Str(with)]) => Int(i32::from(s.starts_with(with.as_str()))),
        ("endswith", [Str(s), Str(with)]) => Int(i32::from(s.ends_with(with.as_str()))),
        ("stoi", [Str(s)]) => Int(leading_int(s)),
        ("stof", [Str(s)]) => Float(leading_float(s)),
        ("getchar", [Str(s), Int(i)]) => {
            // A char of C, 0 outside of the string.
            let byte = usize::try_from(*i).ok().and_then(|i| s.as_bytes().get(i));
            Int(byte.map_or(0, |b| i32::from(*b as i8)))
        }
        ("substr", [Str(s), Int(start)]) => Str(substr(s, *start, i32::MAX)?),
        ("substr", [Str(s), Int(start), Int(len)]) => Str(substr(s, *start, *len)?),
        ("concat", parts) => {
            let parts = parts.iter().map(|p| if let Str(s) = p { Some(s.as_str()) } else { None });
            Str(parts.collect::<Option<Vec<_>>>()?.concat())
        }
        ("format", [Str(pattern), args @ ..]) => Str(format(pattern, args)?),
        _ => return None,
    };
    match &value {
        Str(s) if s.len() > MAX_BYTES => None,
        _ => Some(value),
    }
}

/// `None` when it would cut a character of several bytes.
fn substr(s: &str, start: i32, len: i32) -> Option<String> {
    let size = i64::try_from(s.len()).ok()?;
    // Negative positions count from the end.
    let start = i64::from(start) + if start < 0 { size } else { 0 };
    let start = start.clamp(0, size);
    let end = (start + i64::from(len.max(0))).min(size);
    s.get(start as usize..end as usize).map(str::to_owned)
}

/// What C's strtol reads at the front in base 10; 0 when there is no number, and the nearest int when it is too large.
fn leading_int(s: &str) -> i32 {
    let s = s.trim_start();
    let digits = s.strip_prefix(['+', '-']).unwrap_or(s);
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    let mut value: i64 = 0;
    for b in digits[..end].bytes() {
        value = (value * 10 + i64::from(b - b'0')).min(1 << 40);
    }
    let value = if s.starts_with('-') { -value } else { value };
    value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

/// What C's strtof reads at the front, but for hexadecimal numbers, infinities and NaN; 0 when there is no number.
fn leading_float(s: &str) -> f64 {
    let s = s.trim_start();
    let bytes = s.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let signed = |at: usize| at + usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
    let mut end = digits(signed(0));
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent = signed(end + 1);
        let behind = digits(exponent);
        end = if behind > exponent { behind } else { end };
    }
    let value: f64 = s[..end].parse().unwrap_or(0.0);
    value.clamp(-f64::from(f32::MAX), f64::from(f32::MAX))
}

/// One conversion of a format, such as `%-8.3f`.
#[derive(Clone, Copy, Default)]
struct Spec {
    left: bool,
    plus: bool,
    space: bool,
    zero: bool,
    alternate: bool,
    width: usize,
    precision: Option<usize>,
    kind: u8,
}

/// OSL's `format`, which is C's printf: `None` when arguments are missing or a conversion is none of C's.
fn format(pattern: &str, args: &[Const]) -> Option<String> {
    let mut out = String::new();
    let mut args = args.iter();
    let mut rest = pattern;
    while let Some(at) = rest.find('%') {
        out.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(behind) = rest.strip_prefix('%') {
            out.push('%');
            rest = behind;
            continue;
        }
        let (spec, behind) = read_spec(rest)?;
        rest = behind;
        convert(args.next()?, spec, &mut out)?;
        if out.len() > MAX_BYTES {
            return None;
        }
    }
    out.push_str(rest);
    Some(out)
}

fn read_spec(text: &str) -> Option<(Spec, &str)> {
    let mut spec = Spec::default();
    let mut at = 0;
    let bytes = text.as_bytes();
    loop {
        match bytes.get(at)? {
            b'-' => spec.left = true,
            b'+' => spec.plus = true,
            b' ' => spec.space = true,
            b'0' => spec.zero = true,
            b'#' => spec.alternate = true,
            _ => break,
        }
        at += 1;
    }
    let number = |at: &mut usize| {
        let mut n = 0usize;
        while let Some(b) = bytes.get(*at).filter(|b| b.is_ascii_digit()) {
            n = (n * 10 + usize::from(b - b'0')).min(MAX_WIDTH + 1);
            *at += 1;
        }
        n
    };
    spec.width = number(&mut at);
    if bytes.get(at) == Some(&b'.') {
        at += 1;
        spec.precision = Some(number(&mut at));
    }
    spec.kind = *bytes.get(at)?;
    let known = spec.kind.is_ascii() && b"diuoxXcfFeEgGs".contains(&spec.kind);
    let small = spec.width <= MAX_WIDTH && spec.precision.is_none_or(|p| p <= MAX_WIDTH);
    (known && small).then(|| (spec, &text[at + 1..]))
}

/// Appends a value. Where the conversion does not fit the type, the type's plain one is used, as the reference does: `%d`,
/// `%f`, `%s`. Triples, matrices and arrays are their numbers with blanks between.
fn convert(value: &Const, spec: Spec, out: &mut String) -> Option<()> {
    let mut join = |items: &mut dyn Iterator<Item = Const>| {
        for (i, item) in items.enumerate() {
            if i > 0 {
                out.push(' ');
            }
            convert(&item, spec, out)?;
        }
        Some(())
    };
    match value {
        Const::Triple(v) => return join(&mut v.iter().map(|x| Const::Float(*x))),
        Const::Matrix(m) => return join(&mut m.iter().map(|x| Const::Float(*x))),
        Const::Array(items) => return join(&mut items.iter().cloned()),
        _ => {}
    }
    let (sign, digits, numeric) = match value {
        Const::Int(v) => integer(*v, spec)?,
        Const::Float(x) => {
            // OSL's floats have 32 bits.
            let x = f64::from(*x as f32);
            let sign = if x.is_sign_negative() { "-" } else { positive_sign(spec) };
            (sign, real(x.abs(), spec), x.is_finite())
        }
        Const::Str(s) => {
            let text = match spec.precision {
                Some(p) if spec.kind == b's' => s.get(..p.min(s.len()))?,
                _ => s,
            };
            ("", text.to_owned(), false)
        }
        _ => return None,
    };
    let pad = spec.width.saturating_sub(sign.len() + digits.len());
    let (blank, zeros, behind) = match () {
        () if spec.left => (0, 0, pad),
        () if spec.zero && numeric => (0, pad, 0),
        () => (pad, 0, 0),
    };
    out.push_str(&" ".repeat(blank));
    out.push_str(sign);
    out.push_str(&"0".repeat(zeros));
    out.push_str(&digits);
    out.push_str(&" ".repeat(behind));
    Some(())
}

fn positive_sign(spec: Spec) -> &'static str {
    match (spec.plus, spec.space) {
        (true, _) => "+",
        (_, true) => " ",
        _ => "",
    }
}

/// Sign, digits, and whether zeros may fill the width.
fn integer(v: i32, spec: Spec) -> Option<(&'static str, String, bool)> {
    let bits = v as u32;
    let prefix = |p: &'static str| if spec.alternate && v != 0 { p } else { "" };
    let (sign, mut digits) = match spec.kind {
        b'u' => ("", bits.to_string()),
        b'x' => (prefix("0x"), format!("{bits:x}")),
        b'X' => (prefix("0X"), format!("{bits:X}")),
        b'o' => (prefix("0"), format!("{bits:o}")),
        b'c' => return Some(("", char::from(u8::try_from(v).ok().filter(u8::is_ascii)?).to_string(), false)),
        _ => (if v < 0 { "-" } else { positive_sign(spec) }, v.unsigned_abs().to_string()),
    };
    let precise = matches!(spec.kind, b'd' | b'i' | b'u' | b'x' | b'X' | b'o');
    match spec.precision.filter(|_| precise) {
        // C: with a precision, zeros fill up to it and not to the width.
        Some(p) => {
            digits.insert_str(0, &"0".repeat(p.saturating_sub(digits.len())));
            Some((sign, digits, false))
        }
        None => Some((sign, digits, true)),
    }
}

/// The digits of a number that is not negative.
fn real(x: f64, spec: Spec) -> String {
    let text = if x.is_nan() {
        "nan".to_owned()
    } else if x.is_infinite() {
        "inf".to_owned()
    } else {
        let precision = spec.precision.unwrap_or(6);
        match spec.kind {
            b'e' | b'E' => scientific(x, precision),
            b'g' | b'G' => general(x, precision.max(1), spec.alternate),
            _ => format!("{x:.precision$}"),
        }
    };
    if spec.kind.is_ascii_uppercase() { text.to_uppercase() } else { text }
}

/// C's `%e`: two digits of exponent at least.
fn scientific(x: f64, precision: usize) -> String {
    let text = format!("{x:.precision$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    format!("{mantissa}e{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs())
}

/// C's `%g`: so many digits that count, in the shorter of both ways, without zeros at the end.
fn general(x: f64, digits: usize, keep_zeros: bool) -> String {
    let text = scientific(x, digits - 1);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    let strip = |s: &str| {
        let plain = keep_zeros || !s.contains('.');
        if plain { s.to_owned() } else { s.trim_end_matches('0').trim_end_matches('.').to_owned() }
    };
    if power < -4 || power >= digits as i32 {
        return format!("{}e{exponent}", strip(mantissa));
    }
    let decimals = (digits as i32 - 1 - power).max(0) as usize;
    strip(&format!("{x:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formatted(pattern: &str, value: Const) -> String {
        format(pattern, &[value]).unwrap_or_else(|| panic!("{pattern} fits"))
    }

    #[test]
    fn formats_as_c_does() {
        for (pattern, value, expected) in [
            ("%g", 0.1, "0.1"),
            ("%g", 1e-5, "1e-05"),
            ("%g", 1234567.0, "1.23457e+06"),
            ("%g", 100000.0, "100000"),
            ("%g", 0.0, "0"),
            ("%08.3f|", -1.5, "-001.500|"),
            ("%-8.2e|", 1.5, "1.50e+00|"),
            ("%+d", 2.0, "+2.000000"),
        ] {
            assert_eq!(formatted(pattern, Const::Float(value)), expected, "{pattern} {value}");
        }
        for (pattern, value, expected) in
            [("%03d", 7, "007"), ("%x", -1, "ffffffff"), ("%5d|", -3, "   -3|"), ("%f", 3, "3"), ("%.3d", 5, "005")]
        {
            assert_eq!(formatted(pattern, Const::Int(value)), expected, "{pattern} {value}");
        }
        assert_eq!(formatted("<%s>", Const::Triple([1.0, 0.5, 0.0])), "<1.000000 0.500000 0.000000>");
        assert_eq!(formatted("100%% %5s", Const::Str("ab".into())), "100%    ab");
        assert_eq!(format("%d", &[]), None);
        assert_eq!(format("%y", &[Const::Int(1)]), None);
    }

    #[test]
    fn numbers_are_read_from_the_front() {
        assert_eq!(leading_int("  -12abc"), -12);
        assert_eq!(leading_int("abc"), 0);
        assert_eq!(leading_int("99999999999999999999"), i32::MAX);
        assert_eq!(leading_float("1.5e3x"), 1500.0);
        assert_eq!(leading_float("-.5"), -0.5);
        assert_eq!(leading_float("2e"), 2.0);
        assert_eq!(leading_float("."), 0.0);
    }

    #[test]
    fn parts_of_strings() {
        assert_eq!(substr("hello", -3, 2).as_deref(), Some("ll"));
        assert_eq!(substr("hello", 2, i32::MAX).as_deref(), Some("llo"));
        assert_eq!(substr("hello", 9, 1).as_deref(), Some(""));
        assert_eq!(substr("é", 1, 1), None);
    }
}
