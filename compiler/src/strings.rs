//! Strings on the device: ids that every program agrees on (docs/adr/0003).

/// The id of a string: 0 for `""`, else its 32-bit FNV-1a hash (Fowler, Noll, Vo), with 0 moved to 1. Kernels hold it as
/// `int`, bit for bit.
pub fn string_id(text: &str) -> u32 {
    if text.is_empty() {
        return 0;
    }
    let hash = text.bytes().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
    hash.max(1)
}

#[cfg(test)]
mod tests {
    use super::string_id;

    #[test]
    fn follows_fnv_1a() {
        // Test vectors of the FNV authors.
        assert_eq!(string_id("a"), 0xe40c_292c);
        assert_eq!(string_id("foobar"), 0xbf9c_f968);
        assert_eq!(string_id(""), 0);
    }

    #[test]
    fn the_kernels_know_the_same_ids() {
        let header = include_str!("../../kernels/strings.h");
        let mut seen = 0;
        for line in header.lines().filter(|l| l.starts_with("#define STR_")) {
            let (code, comment) = line.split_once("//").expect("each id names its string");
            let text = comment.trim().trim_matches('"');
            let number = code.split_whitespace().nth(2).expect("a value");
            let id = string_id(text) as i32;
            let expected = if id == i32::MIN { "(-2147483647 - 1)".to_owned() } else { format!("({id})") };
            assert_eq!(number, expected, "{line}");
            seen += 1;
        }
        assert!(seen >= 6);
    }
}
