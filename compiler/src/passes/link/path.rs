//! Paths of connections: a parameter of a layer, with fields, elements and components behind it.
//!
//! In: text such as `s.x`, `arr[2]`, `c[0]`, `arr[1][2]`. Out: the flattened name and the indices.

/// A path in parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Path<'a> {
    /// Name with fields, without brackets. An index in the middle (`s[1].x`) moves to the end: arrays of structs are
    /// structs of arrays.
    pub name: String,
    /// Indices in order.
    pub indices: Vec<u32>,
    /// As written.
    pub text: &'a str,
}

/// Reads a path; what is wrong with it.
pub(super) fn parse(text: &str) -> Result<Path<'_>, String> {
    let mut name = String::new();
    let mut indices = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        if let Some(inside) = rest.strip_prefix('[') {
            let (digits, behind) = inside.split_once(']').ok_or("`[` without `]`")?;
            let index = digits.trim().parse().map_err(|_| format!("`[{digits}]` is no index"))?;
            indices.push(index);
            rest = behind;
        } else {
            let end = rest.find('[').unwrap_or(rest.len());
            name.push_str(&rest[..end]);
            rest = &rest[end..];
        }
    }
    if name.is_empty() {
        return Err("it names no parameter".into());
    }
    Ok(Path { name, indices, text })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_indices() {
        let check = |text: &str, name: &str, indices: &[u32]| {
            let path = parse(text).expect(text);
            assert_eq!((path.name.as_str(), path.indices.as_slice()), (name, indices), "{text}");
        };
        check("f_out", "f_out", &[]);
        check("s.x", "s.x", &[]);
        check("arr[2]", "arr", &[2]);
        check("arr[1][0]", "arr", &[1, 0]);
        check("s[1].c[2]", "s.c", &[1, 2]);
        for wrong in ["", "[1]", "a[", "a[x]", "a[-1]"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
