//! The text between a module and the kernels: OpenCL C functions that the module imports.
//!
//! A module knows neither the kernels' structs nor their library. What needs either is a function of the bridge: it gets
//! the structs as byte pointers, matrices as pointers to 16 reals, triples and numbers by value, and does one thing.
//!
//! In: names, types and bodies of functions. Out: the text, its headers. It must not know the IR's instructions.

use super::module::{Module, Type, Word};
use crate::ir::Ty;
use std::collections::{BTreeSet, HashMap};

/// How a function of the bridge takes an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Param {
    /// The `ShaderGlobals`.
    Globals,
    /// The `ShadeResult`.
    Result,
    /// The `LobeChoice`, in three reals.
    Choice,
    /// A value; of a matrix a pointer to it.
    Value(Ty),
    /// A place that holds one or more of this type.
    Place(Ty),
}

impl Param {
    pub(super) fn ty(self) -> Type {
        match self {
            Param::Globals | Param::Result => Type::BytePointer,
            Param::Choice | Param::Value(Ty::Matrix) | Param::Place(Ty::Float | Ty::Matrix) => Type::RealPointer,
            Param::Value(Ty::Float) => Type::Real,
            Param::Value(Ty::Triple) => Type::Triple,
            Param::Value(_) => Type::Int,
            Param::Place(Ty::Triple) => Type::TriplePointer,
            Param::Place(_) => Type::IntPointer,
        }
    }

    /// What the body calls it by: as the kernels' functions want it.
    fn expression(self, index: usize) -> String {
        match self {
            // A body gets these under names of their own.
            Param::Globals => "sg".to_owned(),
            Param::Result => "out".to_owned(),
            Param::Choice => "choice".to_owned(),
            Param::Value(Ty::Matrix) => format!("*(const mat4 *)a{index}"),
            Param::Place(Ty::Matrix) => format!("(mat4 *)a{index}"),
            Param::Value(_) | Param::Place(_) => format!("a{index}"),
        }
    }
}

/// What a function of the bridge gives back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ret {
    Nothing,
    /// Of a matrix: the first parameter is where it goes.
    Value(Ty),
}

/// The text so far.
pub(super) struct Bridge {
    prefix: String,
    text: String,
    pub includes: BTreeSet<&'static str>,
    functions: HashMap<String, Word>,
}

impl Bridge {
    /// All functions' names begin with the entry's, so that no two artifacts meet.
    pub(super) fn new(entry: &str) -> Bridge {
        Bridge { prefix: entry.to_owned(), text: String::new(), includes: BTreeSet::new(), functions: HashMap::new() }
    }

    /// The name of the entry.
    pub(super) fn entry(&self) -> &str {
        &self.prefix
    }

    /// A function of the bridge, once per name. `body` gets the arguments' texts; with a result, it is an expression, else
    /// statements.
    pub(super) fn function(
        &mut self,
        module: &mut Module,
        name: &str,
        ret: Ret,
        params: &[Param],
        body: impl FnOnce(&[String]) -> String,
    ) -> Word {
        if let Some(id) = self.functions.get(name) {
            return *id;
        }
        let full = format!("{}_{name}", self.prefix);
        let mut types: Vec<Type> = params.iter().map(|p| p.ty()).collect();
        let (result, returns) = match ret {
            Ret::Nothing => (Type::Void, "void"),
            Ret::Value(Ty::Matrix) => {
                types.insert(0, Type::RealPointer);
                (Type::Void, "void")
            }
            Ret::Value(ty) => (Param::Value(ty).ty(), ctype(Param::Value(ty).ty())),
        };
        let mut list = Vec::new();
        let mut locals = String::new();
        if ret == Ret::Value(Ty::Matrix) {
            list.push("real *r".to_owned());
        }
        for (index, param) in params.iter().enumerate() {
            match param {
                Param::Globals => {
                    list.push("uchar *sg_".to_owned());
                    locals.push_str("    const ShaderGlobals *sg = (const ShaderGlobals *)sg_;\n");
                }
                Param::Result => {
                    list.push("uchar *out_".to_owned());
                    locals.push_str("    ShadeResult *out = (ShadeResult *)out_;\n");
                }
                Param::Choice => {
                    list.push("real *choice_".to_owned());
                    locals.push_str("    LobeChoice *choice = (LobeChoice *)choice_;\n");
                }
                other => {
                    let ty = ctype(other.ty());
                    let space = if ty.ends_with('*') { "" } else { " " };
                    list.push(format!("{ty}{space}a{index}"));
                }
            }
        }
        let texts: Vec<String> = params.iter().enumerate().map(|(i, p)| p.expression(i)).collect();
        let body = body(&texts);
        let body = match ret {
            Ret::Nothing => body,
            Ret::Value(Ty::Matrix) => format!("    *(mat4 *)r = {body};\n"),
            Ret::Value(_) => format!("    return {body};\n"),
        };
        let takes_matrix = |p: &&Param| matches!(p, Param::Value(Ty::Matrix) | Param::Place(Ty::Matrix));
        if ret == Ret::Value(Ty::Matrix) || params.iter().any(|p| takes_matrix(&p)) {
            self.includes.insert("osl/matrix.h");
        }
        self.text.push_str(&format!("{returns} {full}({})\n{{\n{locals}{body}}}\n\n", list.join(", ")));
        let id = module.import(&full, result, &types);
        self.functions.insert(name.to_owned(), id);
        id
    }

    /// The whole text: headers, the functions, and the entry that calls the module's function.
    pub(super) fn finish(self, about: &str, signature: &str, outer: &str, inner: &str) -> (String, Vec<String>) {
        let entry = self.prefix;
        // Headers of lobes come last: they build on the others.
        let (lobes, others): (Vec<&str>, Vec<&str>) = self.includes.iter().partition(|h| h.starts_with("bsdf/"));
        let includes: Vec<String> = others.into_iter().chain(lobes).map(str::to_owned).collect();
        let mut text = format!("// {about}: what its SPIR-V module calls, and how it is called.\n");
        for include in &includes {
            text.push_str(&format!("#include \"{include}\"\n"));
        }
        text.push('\n');
        text.push_str(&self.text);
        text.push_str(&format!("void {}({signature});\n", super::exported(&entry)));
        text.push_str(&format!("void {entry}({outer})\n{{\n    {}({inner});\n}}\n", super::exported(&entry)));
        (text, includes)
    }
}

/// OpenCL C's word for a type of a parameter.
fn ctype(ty: Type) -> &'static str {
    match ty {
        Type::Real => "real",
        Type::Triple => "real3",
        Type::BytePointer => "uchar *",
        Type::IntPointer => "int *",
        Type::RealPointer => "real *",
        Type::TriplePointer => "real3 *",
        _ => "int",
    }
}
