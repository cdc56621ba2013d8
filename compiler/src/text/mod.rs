//! OSL's string functions (specification ch. 7.8) on the host: strings are ids on the device, so that only the host can look
//! into them.
//!
//! In: a row's name and its arguments. Out: the value; `None` when the row is none of these or the arguments do not fit.
//! Positions and lengths count bytes, as in OSL. It must not know the syntax tree or any target.

mod format;
mod regex;

pub use format::{Rules, format};

use crate::ir::Const;

/// Longest string that folding makes: concatenation in a loop doubles.
const MAX_BYTES: usize = 1 << 16;

/// The value of a call.
pub fn call(name: &str, args: &[Const]) -> Option<Const> {
    use Const::{Float, Int, Str};
    let value = match (name, args) {
        ("hash_string", [Str(s)]) => Int(hash(s)),
        ("regex_search", [Str(s), Str(pattern)]) => Int(i32::from(regex::search(s, pattern, false, 0).0)),
        ("regex_match", [Str(s), Str(pattern)]) => Int(i32::from(regex::search(s, pattern, true, 0).0)),
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
        ("format", [Str(pattern), args @ ..]) => Str(format(pattern, args, Rules::C)?),
        _ => return None,
    };
    match &value {
        Str(s) if s.len() > MAX_BYTES => None,
        _ => Some(value),
    }
}

/// What a call that writes to an array yields: the elements to write, from the first on, and its result. `room`: the array's
/// length.
pub fn call_with_output(name: &str, args: &[Const], room: usize) -> Option<(Vec<Const>, Const)> {
    use Const::{Int, Str};
    let all = i32::try_from(room).unwrap_or(i32::MAX);
    Some(match (name, args) {
        ("split", [Str(s)]) => split(s, "", all, all),
        ("split", [Str(s), Str(sep)]) => split(s, sep, all, all),
        ("split", [Str(s), Str(sep), Int(most)]) => split(s, sep, *most, all),
        ("regex_search" | "regex_match", [Str(s), Str(pattern)]) => {
            let (found, offsets) = regex::search(s, pattern, name == "regex_match", room);
            (offsets.into_iter().map(Int).collect(), Int(i32::from(found)))
        }
        _ => return None,
    })
}

/// The reference's hash of a string: the low half of FarmHash64, and 0 for the empty one.
fn hash(s: &str) -> i32 {
    if s.is_empty() { 0 } else { farmhash::hash64(s.as_bytes()) as i32 }
}

/// At most `most` parts, the last of which is all the rest; an empty separator stands for any blanks.
fn split(s: &str, separator: &str, most: i32, room: i32) -> (Vec<Const>, Const) {
    let most = most.clamp(0, room) as usize;
    let mut parts: Vec<&str> = Vec::new();
    if separator.is_empty() {
        let blank = |c: char| c.is_ascii_whitespace() || c == '\u{b}';
        let mut rest = s.trim_start_matches(blank);
        while !rest.is_empty() {
            let end = rest.find(blank).filter(|_| parts.len() + 1 < most).unwrap_or(rest.len());
            parts.push(&rest[..end]);
            rest = rest[end..].trim_start_matches(blank);
        }
    } else {
        parts.extend(s.splitn(most.max(1), separator));
    }
    parts.truncate(most);
    let count = Const::Int(parts.len() as i32);
    (parts.into_iter().map(|p| Const::Str(p.to_owned())).collect(), count)
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

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn strings_are_split_as_the_reference_splits() {
        let parts = |s: &str, sep: &str, most: i32| match split(s, sep, most, 10) {
            (parts, Const::Int(n)) => {
                assert_eq!(parts.len(), n as usize);
                parts.into_iter().map(|p| if let Const::Str(s) = p { s } else { String::new() }).collect::<Vec<_>>()
            }
            _ => Vec::new(),
        };
        assert_eq!(parts(" 2 4\t6    8", "", 10), ["2", "4", "6", "8"]);
        assert_eq!(parts("3,6,9,12", ",", 10), ["3", "6", "9", "12"]);
        assert_eq!(parts("3,6,9,12", ",", 2), ["3", "6,9,12"]);
        assert_eq!(parts("a b c", "", 2), ["a", "b c"]);
        assert!(parts("a b", "", 0).is_empty());
    }

    #[test]
    fn hashes_are_the_references() {
        assert_eq!(hash("Hello World!"), -16_050_688);
        assert_eq!(hash(""), 0);
    }
}
