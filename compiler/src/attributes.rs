//! What `getattribute` knows: facts of the compiler's own, and the attributes that the caller gives.
//!
//! In: the names that a shader asks for. Out: constants. It must not know the syntax tree or any target.

use crate::ir::Const;
use crate::types::truncated;

/// A value of an attribute.
pub use crate::ir::Const as Value;

/// The version of OSL that `osl:version` answers.
const VERSION: i32 = 11600;

/// The types of rays that `raytype` knows, with their bits in `ShaderGlobals.raytype` (kernels/globals.h).
pub const RAY_TYPES: [(&str, u32); 6] =
    [("camera", 1), ("shadow", 2), ("diffuse", 4), ("glossy", 8), ("reflection", 16), ("refraction", 32)];

/// A named value of the renderer: of its camera, of the scene, of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Whose it is; empty: it is found without naming an object.
    pub object: String,
    /// Its name.
    pub name: String,
    /// Its type in OSL's words, such as `int[2]`.
    pub ty: String,
    /// The value; arrays as [`Const::Array`].
    pub value: Const,
}

/// The attributes of a compilation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// All of them; the first that fits counts.
    pub list: Vec<Attribute>,
    /// Names of attributes that differ from object to object: the renderer supplies them as userdata, whose name
    /// [`asked`] reads.
    pub varying: Vec<String>,
    /// For some of `varying` all the ints, or all the strings, that objects have there: a shader may make texts of them.
    pub values: Vec<(String, Vec<Const>)>,
    /// What is asked without naming an object is as in `varying`, whatever its name: the scene is not known yet. Questions that
    /// name an object, or choose the name while the shader runs, are errors then.
    pub open: bool,
}

/// The name of the userdata that stands for an attribute that differs from object to object, asked for in this type; an
/// index less than 0 means all of it.
pub(crate) fn userdata_name(name: &str, index: i32, ty: &str) -> String {
    format!("attribute {ty} {index} {name}")
}

/// The attribute that userdata of this name stands for, and which element of it; `None`: it is no attribute.
pub fn asked(userdata: &str) -> Option<(&str, Option<usize>)> {
    let mut words = userdata.strip_prefix("attribute ")?.splitn(3, ' ').skip(1);
    let index = words.next()?.parse::<i32>().ok()?;
    Some((words.next()?, usize::try_from(index).ok()))
}

/// Whether the answer is the compiler's own, whatever the scene.
pub(crate) fn is_own(name: &str) -> bool {
    matches!(name, "osl:version" | "shader:shadername" | "shader:layername" | "shader:groupname")
}

/// One question.
pub(crate) struct Question<'a> {
    pub object: &'a str,
    pub name: &'a str,
    /// Element of an array; less than 0: all of it.
    pub index: i32,
    /// The type of the variable.
    pub ty: &'a str,
}

impl Attributes {
    /// All values of this type that objects have under a name, if that is known.
    pub(crate) fn values_of(&self, name: &str, ty: crate::ir::Ty) -> Option<&[Const]> {
        let (_, values) = self.values.iter().find(|(n, _)| n == name)?;
        (!self.open && values.iter().all(|v| v.ty() == Some(ty))).then_some(values)
    }

    /// The value for userdata of this name, which [`asked`] reads; arrays as [`Const::Array`]. `None`: there is none.
    pub fn answer(&self, userdata: &str) -> Option<Value> {
        let ty = userdata.strip_prefix("attribute ")?.split(' ').next()?;
        let (name, index) = asked(userdata)?;
        let index = index.map_or(-1, |i| i as i32);
        let mut found = self.find(&Question { object: "", name, index, ty })?;
        match (found.len(), split(ty).1) {
            (1, None) => found.pop(),
            _ => Some(Const::Array(found)),
        }
    }

    /// The value for a variable of the question's type: its elements.
    pub(crate) fn find(&self, q: &Question<'_>) -> Option<Vec<Const>> {
        if q.name == "osl:version" {
            return convert("int", vec![Const::Int(VERSION)], q.ty);
        }
        let mine = self.list.iter().filter(|a| a.name == q.name && a.object == q.object);
        mine.filter_map(|a| fit(a, q)).next()
    }
}

fn fit(attribute: &Attribute, q: &Question<'_>) -> Option<Vec<Const>> {
    let items = match &attribute.value {
        Const::Array(items) => items.clone(),
        single => vec![single.clone()],
    };
    if q.index >= 0 {
        let item = items.get(q.index as usize)?.clone();
        return convert(split(&attribute.ty).0, vec![item], q.ty);
    }
    convert(&attribute.ty, items, q.ty)
}

/// Conversions of the specification: int and float, a scalar to a triple, triples among each other, a float to two, two
/// floats to a triple. The reference's testshade has none of them; renderers have, and our testshade.
fn convert(from: &str, items: Vec<Const>, to: &str) -> Option<Vec<Const>> {
    if from == to {
        return Some(items);
    }
    let triple = |ty: &str| matches!(ty, "color" | "point" | "vector" | "normal");
    Some(match (from, items.as_slice(), to) {
        ("int", [Const::Int(v)], "float") => vec![Const::Float(f64::from(*v))],
        ("float", [Const::Float(v)], "int") => vec![Const::Int(truncated(*v))],
        ("int", [Const::Int(v)], to) if triple(to) => vec![Const::Triple([f64::from(*v); 3])],
        ("float", [Const::Float(v)], to) if triple(to) => vec![Const::Triple([*v; 3])],
        ("float", [Const::Float(v)], "float[2]") => vec![Const::Float(*v), Const::Float(*v)],
        ("float[2]", [Const::Float(a), Const::Float(b)], to) if triple(to) => vec![Const::Triple([*a, *b, 0.0])],
        (from, [Const::Triple(v)], to) if triple(from) && triple(to) => vec![Const::Triple(*v)],
        _ => return None,
    })
}

/// Base and length.
fn split(ty: &str) -> (&str, Option<u32>) {
    match ty.trim_end_matches(']').split_once('[') {
        Some((base, len)) => (base, len.parse().ok()),
        None => (ty, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_convert() {
        let list = vec![
            Attribute { object: String::new(), name: "w".into(), ty: "float".into(), value: Const::Float(2.7) },
            Attribute {
                object: "cam".into(),
                name: "res".into(),
                ty: "int[2]".into(),
                value: Const::Array(vec![Const::Int(4), Const::Int(3)]),
            },
        ];
        let known = Attributes { list, ..Attributes::default() };
        let ask = |object, name, index, ty| known.find(&Question { object, name, index, ty });
        assert_eq!(ask("", "w", -1, "int"), Some(vec![Const::Int(2)]));
        assert_eq!(ask("", "w", -1, "color"), Some(vec![Const::Triple([2.7; 3])]));
        assert_eq!(ask("", "w", -1, "float[2]"), Some(vec![Const::Float(2.7); 2]));
        assert_eq!(ask("", "w", -1, "string"), None);
        assert_eq!(ask("cam", "res", 1, "int"), Some(vec![Const::Int(3)]));
        assert_eq!(ask("cam", "res", 1, "float"), Some(vec![Const::Float(3.0)]));
        assert_eq!(ask("", "res", 1, "int"), None);
        assert_eq!(ask("", "osl:version", -1, "int"), Some(vec![Const::Int(11600)]));
        assert_eq!(ask("", "osl:version", -1, "float"), Some(vec![Const::Float(11600.0)]));
    }

    #[test]
    fn names_of_userdata_read_back() {
        assert_eq!(asked(&userdata_name("a b", -1, "float[2]")), Some(("a b", None)));
        assert_eq!(asked(&userdata_name("w", 3, "int")), Some(("w", Some(3))));
        assert_eq!(asked("st"), None);
        let list = vec![Attribute {
            object: String::new(),
            name: "a b".into(),
            ty: "float[2]".into(),
            value: Const::Array(vec![Const::Float(4.0), Const::Float(3.0)]),
        }];
        let known = Attributes { list, ..Attributes::default() };
        let answer = |index, ty| known.answer(&userdata_name("a b", index, ty));
        assert_eq!(answer(1, "float"), Some(Const::Float(3.0)));
        assert_eq!(answer(-1, "point"), Some(Const::Triple([4.0, 3.0, 0.0])));
        assert_eq!(answer(-1, "float[2]"), Some(Const::Array(vec![Const::Float(4.0), Const::Float(3.0)])));
        assert_eq!(answer(-1, "int"), None);
    }

    #[test]
    fn the_kernels_know_the_same_types_of_rays() {
        let header = include_str!("../../kernels/globals.h");
        let bits: Vec<(String, u32)> = header
            .lines()
            .filter_map(|l| l.strip_prefix("#define RAY_")?.split_once(' '))
            .map(|(name, bit)| (name.to_lowercase(), bit.parse().expect("a bit")))
            .collect();
        assert_eq!(bits, RAY_TYPES.map(|(name, bit)| (name.to_owned(), bit)));
    }
}
