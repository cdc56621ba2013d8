//! Reads command lines in the manner of the reference implementation's tools: options of one or two dashes, each with a
//! fixed number of values, `-Idir` and `-I dir`, `--param:lockgeom=0`.
//!
//! In: arguments and a table of options. Out: [`Item`]s in their order. It must not know what they mean.

use oslcl_compiler::suggest;

/// One row of a tool's table.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Its names without dashes; the first is the one that [`Item::name`] tells.
    pub names: &'static [&'static str],
    /// What follows it.
    pub takes: Takes,
    /// Its values and what it does, for the help text; empty: not shown.
    pub help: &'static str,
}

/// What follows an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// Nothing.
    Nothing,
    /// So many arguments.
    Values(usize),
    /// One value, in the same argument or in the next.
    Joined,
    /// Any letters in the same argument; they become the value.
    Rest,
}

/// An option or a plain argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// The first name of its row; empty: a plain argument, which is the only value.
    pub name: &'static str,
    /// What followed a `:` in the option, as in `--param:lockgeom=0`.
    pub modifiers: String,
    /// Its values.
    pub values: Vec<String>,
}

impl Item {
    /// The first value; empty when there is none.
    pub fn value(&self) -> &str {
        self.values.first().map_or("", String::as_str)
    }
}

/// A row of a table.
pub const fn spec(names: &'static [&'static str], takes: Takes, help: &'static str) -> Spec {
    Spec { names, takes, help }
}

/// Reads a whole command line. The error is a sentence that names the option.
pub fn read(args: &[String], table: &[Spec]) -> Result<Vec<Item>, String> {
    let mut items = Vec::new();
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        let Some(written) = option_text(arg) else {
            items.push(Item { name: "", modifiers: String::new(), values: vec![arg.clone()] });
            continue;
        };
        let (name, modifiers) = written.split_once(':').unwrap_or((written, ""));
        let exact = table.iter().find(|s| s.names.contains(&name));
        let joined = || {
            let open = |s: &&Spec| matches!(s.takes, Takes::Joined | Takes::Rest);
            let fits = |s: &Spec| s.names.iter().filter(|n| written.starts_with(**n)).map(|n| n.len()).max();
            table.iter().filter(open).filter_map(|s| Some((fits(s)?, s))).max_by_key(|(length, _)| *length)
        };
        let (row, modifiers, mut values) = match exact {
            Some(row) => (row, modifiers, Vec::new()),
            None => match joined() {
                Some((length, row)) => (row, "", vec![written[length..].to_owned()]),
                None => return Err(unknown(arg, name, table)),
            },
        };
        let missing = match row.takes {
            Takes::Nothing | Takes::Rest => 0,
            Takes::Values(n) => n,
            Takes::Joined => usize::from(values.is_empty()),
        };
        for _ in 0..missing {
            match args.next() {
                Some(value) => values.push(value.clone()),
                None => return Err(format!("option `{arg}` needs {}", counted(missing))),
            }
        }
        items.push(Item { name: row.names[0], modifiers: modifiers.to_owned(), values });
    }
    Ok(items)
}

/// What stands behind the dashes of an option; `None` for a plain argument, also a lone dash and a number.
fn option_text(arg: &str) -> Option<&str> {
    let rest = arg.strip_prefix('-')?;
    let rest = rest.strip_prefix('-').unwrap_or(rest);
    let number = rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    (!rest.is_empty() && !number).then_some(rest)
}

fn counted(n: usize) -> String {
    if n == 1 { "a value".to_owned() } else { format!("{n} values") }
}

fn unknown(arg: &str, name: &str, table: &[Spec]) -> String {
    let known = table.iter().flat_map(|s| s.names.iter().copied());
    match suggest::closest(name, known) {
        Some(near) => format!("unknown option `{arg}`; did you mean `-{near}`?"),
        None => format!("unknown option `{arg}`"),
    }
}

/// The options with their help, a line each.
pub fn help(table: &[Spec]) -> String {
    let shown: Vec<(String, &str)> = table
        .iter()
        .filter(|s| !s.help.is_empty())
        .map(|s| {
            let names: Vec<String> = s.names.iter().map(|n| format!("-{n}")).collect();
            (names.join(", "), s.help)
        })
        .collect();
    let width = shown.iter().map(|(names, _)| names.len()).max().unwrap_or(0);
    shown.iter().map(|(names, help)| format!("    {names:width$}  {help}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &[Spec] = &[
        spec(&["v", "verbose"], Takes::Nothing, "Say more"),
        spec(&["param"], Takes::Values(2), "NAME VALUE: set a parameter"),
        spec(&["I"], Takes::Joined, "DIR: look here"),
        spec(&["MF"], Takes::Joined, ""),
        spec(&["W"], Takes::Rest, ""),
        spec(&["M"], Takes::Nothing, ""),
    ];

    fn args(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    fn show(text: &str) -> String {
        match read(&args(text), TABLE) {
            Ok(items) => {
                let one = |i: &Item| format!("{}[{}]({})", i.name, i.modifiers, i.values.join(","));
                items.iter().map(one).collect::<Vec<_>>().join(" ")
            }
            Err(message) => message,
        }
    }

    #[test]
    fn options_and_plain_arguments_keep_their_order() {
        assert_eq!(show("-v a --verbose - -1.5"), "v[]() [](a) v[]() [](-) [](-1.5)");
        assert_eq!(show("--param:lockgeom=0 Kd -3 x"), "param[lockgeom=0](Kd,-3) [](x)");
        assert_eq!(show("-Ia/b -I c -MFx.d -MF y.d -M -Wall"), "I[](a/b) I[](c) MF[](x.d) MF[](y.d) M[]() W[](all)");
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert_eq!(show("--param Kd"), "option `--param` needs 2 values");
        assert_eq!(show("-I"), "option `-I` needs a value");
        assert_eq!(show("-verbos"), "unknown option `-verbos`; did you mean `-verbose`?");
        assert_eq!(show("--qqqqq"), "unknown option `--qqqqq`");
    }
}
