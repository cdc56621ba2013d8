//! Numbers as text: C's `%g`, exact decimals.
//!
//! In: values. Out: their spellings, and back. It must not know what they are for.

/// A number as C's `%.Ng` prints it.
pub fn general(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return if value.is_nan() {
            "nan"
        } else if value > 0.0 {
            "inf"
        } else {
            "-inf"
        }
        .to_owned();
    }
    let digits = digits.max(1);
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if exponent < -4 || exponent >= digits as i32 {
        let sign = if exponent < 0 { '-' } else { '+' };
        return format!("{}e{sign}{:02}", trim(mantissa), exponent.abs());
    }
    let places = (digits as i32 - 1 - exponent).max(0) as usize;
    trim(&format!("{value:.places$}")).to_owned()
}

fn trim(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// The shortest decimal that reads back as the same number, also where it is read as 64 bits: nothing is lost on the way
/// through the file. What no file can say becomes the largest number.
pub fn exact(value: f64) -> String {
    if value.is_nan() {
        return "0".to_owned();
    }
    let value = value.clamp(-1e39, 1e39);
    let size = value.abs();
    if size != 0.0 && !(1e-5..1e15).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn general_is_that_of_c() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (0.1, "0.1"),
            (0.75, "0.75"),
            (100000.0, "100000"),
            (1e6, "1e+06"),
            (123456789.0, "1.23457e+08"),
            (0.0001, "0.0001"),
            (0.00001234, "1.234e-05"),
            (-2.5, "-2.5"),
            (0.1 + 0.2, "0.3"),
            (999999.5, "1e+06"),
        ];
        for (value, text) in cases {
            assert_eq!(general(value, 6), text);
        }
        assert_eq!(general(f64::from(0.1f32), 9), "0.100000001");
    }

    #[test]
    fn exact_loses_nothing() {
        for v in [0.1, -0.0, 1.0 / 3.0, 1e-30, 6.02e23, f64::MIN_POSITIVE, 12345678.9] {
            assert_eq!(exact(v).parse::<f64>().map(f64::to_bits), Ok(v.to_bits()));
        }
    }
}
