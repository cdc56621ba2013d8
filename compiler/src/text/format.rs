//! Formats: the reference converts each C conversion to one of the {fmt} library, and what prints at run time goes through
//! that; what it folds goes through C's own printf.
//!
//! In: a pattern and values. Out: the text. Where a conversion does not fit its value's type, the type's plain one is used:
//! `%d`, `%f`, `%s`. Triples, matrices and arrays are their numbers with blanks between. The two sets of [`Rules`] differ in
//! strings with a width, and in what they refuse.

use crate::ir::Const;

/// Largest width and precision that a format may ask for.
const MAX_WIDTH: usize = 1024;

/// Longest text that a format makes.
const MAX_BYTES: usize = 1 << 20;

/// Conversions that a `%` runs up to (the reference's list).
const CONVERSIONS: &str = "cdefgimnopsuvxX";

/// Whose conversions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rules {
    /// C's printf, as far as both sides agree; what it does not know is refused.
    C,
    /// The {fmt} library's, by way of the reference's translation. What it refuses becomes a text that says so.
    Fmt,
}

/// The text of a pattern; `None` when there are fewer values than conversions, when the text grows too long, or when
/// [`Rules::C`] refuse a conversion.
pub fn format(pattern: &str, args: &[Const], rules: Rules) -> Option<String> {
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
        let Some(end) = rest.find(|c| CONVERSIONS.contains(c)) else {
            // The reference reads on to the end of the pattern.
            args.next()?;
            let text = match rules {
                Rules::C => return None,
                Rules::Fmt => refusal(rest, "invalid format specifier"),
            };
            out.push_str(&text);
            return Some(out);
        };
        let (conversion, behind) = rest.split_at(end + 1);
        rest = behind;
        value(args.next()?, conversion, rules, &mut out)?;
        if out.len() > MAX_BYTES {
            return None;
        }
    }
    out.push_str(rest);
    Some(out)
}

/// What the reference prints for a conversion that {fmt} throws at.
fn refusal(spec: &str, why: &str) -> String {
    format!("MIS-FORMAT: format \"{{:{spec}}}\" threw \"{why}\"")
}

/// Appends a value.
fn value(value: &Const, conversion: &str, rules: Rules, out: &mut String) -> Option<()> {
    match value {
        Const::Triple(v) => return join(&mut v.iter().map(|x| Const::Float(*x)), conversion, rules, out),
        Const::Matrix(m) => return join(&mut m.iter().map(|x| Const::Float(*x)), conversion, rules, out),
        Const::Array(items) => return join(&mut items.iter().cloned(), conversion, rules, out),
        _ => {}
    }
    let (flags, given) = conversion.split_at(conversion.len() - 1);
    let given = given.as_bytes().first().copied()?;
    let kind = match value {
        Const::Int(_) if b"doxX".contains(&given) || (rules == Rules::C && b"uc".contains(&given)) => given,
        Const::Int(_) if given == b'u' => given,
        Const::Int(_) => b'd',
        Const::Float(_) if b"fge".contains(&given) => given,
        Const::Float(_) => b'f',
        _ => b's',
    };
    let spec = match rules {
        Rules::C => Spec::read_c(flags),
        Rules::Fmt => Spec::read_fmt(&translated(flags)),
    };
    let refuse = |why: &str| match rules {
        Rules::C => None,
        Rules::Fmt => Some(refusal(&format!("{}{}", translated(flags), char::from(kind)), why)),
    };
    let text = match (spec, value) {
        (None, _) => refuse("invalid format specifier"),
        (Some(spec), Const::Int(v)) => spec.int(*v, kind, rules, &refuse),
        (Some(spec), Const::Float(x)) => Some(spec.float(*x, kind)),
        (Some(spec), Const::Str(s)) => spec.string(s, rules, &refuse),
        _ => None,
    };
    out.push_str(&text?);
    Some(())
}

fn join(items: &mut dyn Iterator<Item = Const>, conversion: &str, rules: Rules, out: &mut String) -> Option<()> {
    for (i, item) in items.enumerate() {
        if i > 0 {
            out.push(' ');
        }
        value(&item, conversion, rules, out)?;
    }
    Some(())
}

/// C's flags as the reference hands them to {fmt}: the first `-` is `<`, the others go.
fn translated(flags: &str) -> String {
    let mut first = true;
    let keep = |c: char| match c {
        '-' if std::mem::replace(&mut first, false) => Some('<'),
        '-' => None,
        c => Some(c),
    };
    flags.chars().filter_map(keep).collect()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Align {
    /// The type's own.
    Plain,
    Left,
    Right,
    Center,
    /// Zeros between sign and digits.
    Zeros,
}

/// One conversion, such as `-8.3`, without its letter.
#[derive(Clone, Copy, Debug)]
struct Spec {
    fill: char,
    align: Align,
    plus: bool,
    space: bool,
    alternate: bool,
    /// The flag `0`, whether it counts or not.
    zero: bool,
    width: usize,
    precision: Option<usize>,
}

fn alignment(c: char) -> Option<Align> {
    match c {
        '<' => Some(Align::Left),
        '>' => Some(Align::Right),
        '^' => Some(Align::Center),
        _ => None,
    }
}

/// Reads a number off the front; more digits than matter are all the same.
fn number(text: &str) -> (usize, &str) {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let value = text[..end].bytes().fold(0usize, |n, b| (n * 10 + usize::from(b - b'0')).min(MAX_WIDTH + 1));
    (value, &text[end..])
}

impl Spec {
    const PLAIN: Spec = Spec {
        fill: ' ',
        align: Align::Plain,
        plus: false,
        space: false,
        alternate: false,
        zero: false,
        width: 0,
        precision: None,
    };

    fn read_c(text: &str) -> Option<Spec> {
        let mut spec = Spec::PLAIN;
        let end = text.find(|c| !"-+ 0#".contains(c)).unwrap_or(text.len());
        let (flags, rest) = text.split_at(end);
        spec.plus = flags.contains('+');
        spec.space = flags.contains(' ');
        spec.alternate = flags.contains('#');
        spec.zero = flags.contains('0');
        spec.align = match (flags.contains('-'), spec.zero) {
            (true, _) => Align::Left,
            (_, true) => Align::Zeros,
            _ => Align::Plain,
        };
        spec.sizes(rest).filter(|(_, rest)| rest.is_empty()).map(|(spec, _)| spec)
    }

    fn read_fmt(text: &str) -> Option<Spec> {
        let mut spec = Spec::PLAIN;
        let mut rest = text;
        let mut chars = text.chars();
        match (chars.next(), chars.next()) {
            (Some(fill), Some(c)) if alignment(c).is_some() && fill != '{' => {
                (spec.fill, spec.align) = (fill, alignment(c)?);
                rest = &text[fill.len_utf8() + 1..];
            }
            (Some(c), _) if alignment(c).is_some() => {
                spec.align = alignment(c)?;
                rest = &text[1..];
            }
            _ => {}
        }
        let flag = |rest: &mut &str, c: char| match rest.strip_prefix(c) {
            Some(behind) => {
                *rest = behind;
                true
            }
            None => false,
        };
        spec.plus = flag(&mut rest, '+');
        if !spec.plus && !flag(&mut rest, '-') {
            spec.space = flag(&mut rest, ' ');
        }
        spec.alternate = flag(&mut rest, '#');
        spec.zero = flag(&mut rest, '0');
        if spec.zero && spec.align == Align::Plain {
            spec.align = Align::Zeros;
        }
        spec.sizes(rest).filter(|(_, rest)| rest.is_empty()).map(|(spec, _)| spec)
    }

    /// Width and precision.
    fn sizes(mut self, text: &str) -> Option<(Spec, &str)> {
        let (width, mut rest) = number(text);
        self.width = width;
        if let Some(behind) = rest.strip_prefix('.') {
            let (precision, behind) = number(behind);
            (self.precision, rest) = (Some(precision), behind);
        }
        let small = self.width <= MAX_WIDTH && self.precision.is_none_or(|p| p <= MAX_WIDTH);
        small.then_some((self, rest))
    }

    fn sign(&self, negative: bool) -> &'static str {
        match (negative, self.plus, self.space) {
            (true, ..) => "-",
            (_, true, _) => "+",
            (_, _, true) => " ",
            _ => "",
        }
    }

    /// Fills up to the width; `plain`: how the type is aligned when nothing is said.
    fn pad(&self, sign: &str, body: &str, plain: Align) -> String {
        let missing = self.width.saturating_sub(sign.chars().count() + body.chars().count());
        let align = if self.align == Align::Plain { plain } else { self.align };
        let fill = |n: usize| self.fill.to_string().repeat(n);
        match align {
            Align::Left => format!("{sign}{body}{}", fill(missing)),
            Align::Center => format!("{}{sign}{body}{}", fill(missing / 2), fill(missing - missing / 2)),
            Align::Zeros => format!("{sign}{}{body}", "0".repeat(missing)),
            Align::Plain | Align::Right => format!("{}{sign}{body}", fill(missing)),
        }
    }

    fn string(self, s: &str, rules: Rules, refuse: &dyn Fn(&str) -> Option<String>) -> Option<String> {
        if rules == Rules::Fmt && (self.plus || self.space || self.alternate || self.zero) {
            return refuse("format specifier requires numeric argument");
        }
        let mut end = self.precision.unwrap_or(s.len()).min(s.len());
        while !s.is_char_boundary(end) {
            end -= 1;
        }
        let plain = if rules == Rules::C { Align::Right } else { Align::Left };
        let spec = if self.align == Align::Zeros { Spec { align: Align::Plain, ..self } } else { self };
        Some(spec.pad("", &s[..end], plain))
    }

    fn int(self, v: i32, kind: u8, rules: Rules, refuse: &dyn Fn(&str) -> Option<String>) -> Option<String> {
        let bits = v as u32;
        let prefix = |p: &'static str| if self.alternate && v != 0 { p } else { "" };
        let (sign, mut digits) = match kind {
            b'x' => (prefix("0x").to_owned(), format!("{bits:x}")),
            b'X' => (prefix("0X").to_owned(), format!("{bits:X}")),
            b'o' if rules == Rules::C => (prefix("0").to_owned(), format!("{bits:o}")),
            b'o' => (self.sign(v < 0).to_owned() + prefix("0"), format!("{:o}", v.unsigned_abs())),
            b'u' if rules == Rules::C => (String::new(), bits.to_string()),
            b'u' => return refuse("invalid format specifier"),
            b'c' => {
                let c = char::from(u8::try_from(v).ok().filter(u8::is_ascii)?).to_string();
                return Some(self.pad("", &c, Align::Right));
            }
            _ => (self.sign(v < 0).to_owned(), v.unsigned_abs().to_string()),
        };
        let Some(precision) = self.precision else { return Some(self.pad(&sign, &digits, Align::Right)) };
        if rules == Rules::Fmt {
            return refuse("precision not allowed for this argument type");
        }
        // C: with a precision, zeros fill up to it and not to the width.
        digits.insert_str(0, &"0".repeat(precision.saturating_sub(digits.len())));
        let spec = if self.align == Align::Zeros { Spec { align: Align::Right, ..self } } else { self };
        Some(spec.pad(&sign, &digits, Align::Right))
    }

    fn float(self, x: f64, kind: u8) -> String {
        // OSL's floats have 32 bits.
        let x = f64::from(x as f32);
        let sign = self.sign(x.is_sign_negative());
        let finite = x.is_finite();
        let spec = if !finite && self.align == Align::Zeros { Spec { align: Align::Right, ..self } } else { self };
        spec.pad(sign, &real(x.abs(), kind, self.precision, self.alternate), Align::Right)
    }
}

/// The digits of a number that is not negative.
fn real(x: f64, kind: u8, precision: Option<usize>, alternate: bool) -> String {
    if x.is_nan() {
        return "nan".to_owned();
    }
    if x.is_infinite() {
        return "inf".to_owned();
    }
    let precision = precision.unwrap_or(6);
    match kind {
        b'e' => scientific(x, precision),
        b'g' => general(x, precision.max(1), alternate),
        _ if alternate && precision == 0 => format!("{x:.0}."),
        _ => format!("{x:.precision$}"),
    }
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

    fn formatted(pattern: &str, value: Const, rules: Rules) -> String {
        format(pattern, &[value], rules).unwrap_or_else(|| panic!("{pattern} fits"))
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
            for rules in [Rules::C, Rules::Fmt] {
                assert_eq!(formatted(pattern, Const::Float(value), rules), expected, "{pattern} {value}");
            }
        }
        for (pattern, value, expected) in
            [("%03d", 7, "007"), ("%x", -1, "ffffffff"), ("%5d|", -3, "   -3|"), ("%f", 3, "3"), ("%.3d", 5, "005")]
        {
            assert_eq!(formatted(pattern, Const::Int(value), Rules::C), expected, "{pattern} {value}");
        }
        assert_eq!(formatted("<%s>", Const::Triple([1.0, 0.5, 0.0]), Rules::C), "<1.000000 0.500000 0.000000>");
        assert_eq!(formatted("100%% %5s", Const::Str("ab".into()), Rules::C), "100%    ab");
        assert_eq!(format("%d", &[], Rules::C), None);
        assert_eq!(format("%y", &[Const::Int(1)], Rules::C), None);
    }

    #[test]
    fn formats_as_the_reference_prints() {
        let int = |pattern: &str, v| formatted(pattern, Const::Int(v), Rules::Fmt);
        assert_eq!(int("%#x", 10), "0xa");
        assert_eq!(int("%#o", 9), "011");
        assert_eq!(int("%o", -9), "-11");
        assert_eq!(int("%+05d", 12), "+0012");
        assert_eq!(int("{****%------4d****}", 678), "{****678 ****}");
        assert_eq!(int("%i", 3), "3");
        assert_eq!(int("%c", 65), "65");
        assert_eq!(int("%x", -1), "ffffffff");
        assert!(int("%.3d", 5).starts_with("MIS-FORMAT"));
        assert_eq!(formatted("%5s|%%", Const::Str("ab".into()), Rules::Fmt), "ab   |%");
        assert_eq!(formatted("%.2s|", Const::Str("abc".into()), Rules::Fmt), "ab|");
        assert_eq!(formatted("%0.8f", Const::Float(1.23232), Rules::Fmt), "1.23231995");
        assert_eq!(formatted("%02f", Const::Float(1.3), Rules::Fmt), "1.300000");
        assert_eq!(formatted("%06f", Const::Float(f64::NAN), Rules::Fmt).trim_start_matches('-'), "   nan");
        let array = Const::Array(vec![Const::Int(1), Const::Int(2)]);
        assert_eq!(formatted("%d", array, Rules::Fmt), "1 2");
    }
}
