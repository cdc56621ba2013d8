//! Shader packages: compiled shaders in one file, which a render takes without any compiler. docs/packages.md is the manual,
//! docs/adr/0020-packages.md says what is decided when.
//!
//! In: OSL sources or groups and what to leave open ([`make`]), or a file ([`Package::read`]). Out: the file's bytes, or artifacts for a
//! scene's materials (`take`). It must not know devices.

mod error;
mod facts;
pub mod file;
pub mod make;
mod points;
pub(crate) mod take;

pub use error::Error;
pub use facts::Fact;
pub use take::shown;

use crate::shader_group;
use oslcl_compiler::artifact::Stored;
use oslcl_compiler::reflect::{ShaderInfo, Value};
use oslcl_compiler::types::Type;
use oslcl_compiler::{Artifact, Binding, suggest};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// One function of a shader, compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// What a render reads.
    pub artifact: Artifact,
    /// Why it has no SPIR-V, where it has none.
    pub no_spirv: Option<String>,
}

/// A shader of a package.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shader {
    /// The name by which scenes know it.
    pub name: String,
    /// The file that it was made of.
    pub source: String,
    /// What runs on surfaces and in the environment; of a displacement shader what moves vertices.
    #[serde(with = "stored::form")]
    pub main: Form,
    /// What moves vertices, of a shader that is declared as any kind.
    #[serde(with = "stored::optional")]
    pub mover: Option<Form>,
    /// Why there is no `mover` of such a shader.
    pub no_mover: Option<String>,
    /// For points without a scene: stores what `oslcl shade` shows of the shader.
    #[serde(with = "stored::optional")]
    pub points: Option<Form>,
    /// Why there is no `points`.
    pub no_points: Option<String>,
    /// The layers of a group, whose parameters are called `layer.param`; empty of a shader alone.
    pub layers: Vec<String>,
    /// What there is to say of its parameters.
    pub params: Vec<Parameter>,
    /// Parameters that are a texture coordinate of the surface, wherever the shader runs.
    pub coordinates: Vec<String>,
    /// What is built into the code about texture files.
    pub facts: Vec<Fact>,
}

impl Shader {
    /// Parameters, defaults and metadata as written.
    pub fn info(&self) -> &ShaderInfo {
        &self.main.artifact.info
    }

    /// What moves vertices, if it can.
    pub fn mover(&self) -> Option<&Form> {
        if self.main.artifact.kind == "displacement" { Some(&self.main) } else { self.mover.as_ref() }
    }

    /// The name of a parameter among `params`: one of a group's last layer needs no layer's name.
    pub fn full_name(&self, name: &str) -> String {
        match self.layers.is_empty() {
            true => name.to_owned(),
            false => shader_group::full_name(name, self.layers.iter().map(String::as_str)),
        }
    }

    /// The parameter of this full name, or the struct that has it as a field.
    pub fn param(&self, name: &str) -> Option<&Parameter> {
        let whole = |p: &&Parameter| name.strip_prefix(&p.name).is_some_and(|rest| rest.starts_with('.'));
        self.params.iter().find(|p| p.name == name).or_else(|| self.params.iter().find(whole))
    }
}

/// A parameter of a shader in a package.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name; of a field of a struct that was given a value `a.x`.
    pub name: String,
    /// Its type; `None` of a field.
    pub ty: Option<Type>,
    /// The type in OSL's words; empty of a field.
    pub words: String,
    /// The value in the code, or that of an open one which nobody sets; `None`: it is computed.
    pub value: Option<Binding>,
    /// The value is not the default.
    pub given: bool,
    /// Values are read at run time.
    pub open: bool,
}

/// A default of reflection as a value to bind.
fn as_binding(value: &Value) -> Binding {
    fn flat(value: &Value, numbers: &mut Vec<f64>, texts: &mut Vec<String>) {
        match value {
            Value::Int(v) => numbers.push(f64::from(*v)),
            Value::Float(v) => numbers.push(*v),
            Value::Str(s) => texts.push(s.clone()),
            Value::List(items) => items.iter().for_each(|v| flat(v, numbers, texts)),
        }
    }
    match value {
        Value::Int(v) => Binding::Int(i64::from(*v)),
        Value::Float(v) => Binding::Float(*v),
        Value::Str(s) => Binding::Str(s.clone()),
        Value::List(_) => {
            let (mut numbers, mut texts) = (Vec::new(), Vec::new());
            flat(value, &mut numbers, &mut texts);
            if texts.is_empty() { Binding::Floats(numbers) } else { Binding::Strs(texts) }
        }
    }
}

/// What stands in front of the shaders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Table {
    /// Version of oslcl.
    made_by: String,
    shaders: Vec<Row>,
}

/// A shader in the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Row {
    name: String,
    /// Of its part of the file.
    bytes: u64,
}

/// A package's file, checked as a whole; its shaders are decoded when they are asked for.
#[derive(Clone, Debug)]
pub struct Package {
    path: PathBuf,
    table: Table,
    /// Those of all shaders, one behind the other.
    bodies: Vec<u8>,
}

impl Package {
    /// Reads a file. Files that are no packages, truncated, damaged, or made for another interface between artifacts and
    /// kernels are refused.
    pub fn read(path: &Path) -> Result<Package, Error> {
        let bytes = std::fs::read(path).map_err(|cause| Error::Read { path: path.to_owned(), cause })?;
        Package::from_bytes(path, &bytes)
    }

    /// As [`Package::read`], of what was read; `path` is for messages.
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Package, Error> {
        let contents = file::open(path, bytes)?;
        let malformed = |cause: String| Error::Malformed { path: path.to_owned(), cause };
        let (table, bodies) =
            file::split(contents).ok_or_else(|| malformed("it has no table of shaders".to_owned()))?;
        let table: Table = ciborium::from_reader(table).map_err(|e| malformed(format!("its table of shaders: {e}")))?;
        let bytes = table.shaders.iter().try_fold(0_u64, |sum, row| sum.checked_add(row.bytes));
        if bytes != Some(bodies.len() as u64) {
            return Err(malformed("its table of shaders does not fit them".to_owned()));
        }
        Ok(Package { path: path.to_owned(), table, bodies: bodies.to_vec() })
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The version of oslcl that made it.
    pub fn made_by(&self) -> &str {
        &self.table.made_by
    }

    /// The names of its shaders, in the order in which they were given.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.table.shaders.iter().map(|row| row.name.as_str())
    }

    /// The shader of this name; without a name the only one.
    pub fn shader(&self, name: Option<&str>) -> Result<Shader, Error> {
        let name = match (name, self.table.shaders.as_slice()) {
            (Some(name), _) => name,
            (None, [only]) => &only.name,
            (None, all) => {
                let names = all.iter().map(|row| row.name.clone()).collect();
                return Err(Error::WhichShader { path: self.path.clone(), names });
            }
        };
        let mut first = 0;
        for row in &self.table.shaders {
            let end = first + row.bytes as usize;
            if row.name == name {
                let shader = ciborium::from_reader(&self.bodies[first..end]);
                return shader
                    .map_err(|e| Error::Malformed { path: self.path.clone(), cause: format!("shader `{name}`: {e}") });
            }
            first = end;
        }
        let help = match suggest::closest(name, self.names()) {
            Some(near) => format!("\n  help: did you mean `{near}`?"),
            None => format!("\n  help: it has {}", self.names().collect::<Vec<_>>().join(", ")),
        };
        Err(Error::NoShader { path: self.path.clone(), name: name.to_owned(), help })
    }
}

/// A file with these shaders, whose names differ.
pub fn bytes(shaders: &[Shader]) -> Vec<u8> {
    let mut table = Table { made_by: env!("CARGO_PKG_VERSION").to_owned(), shaders: Vec::new() };
    let mut bodies = Vec::new();
    for shader in shaders {
        let body = file::encoded(shader);
        table.shaders.push(Row { name: shader.name.clone(), bytes: body.len() as u64 });
        bodies.extend(body);
    }
    file::seal(oslcl_compiler::artifact::ABI_VERSION, &file::join(&file::encoded(&table), &bodies))
}

/// Forms with what the JSON of their artifacts leaves out.
mod stored {
    use super::{Artifact, Form, Stored};
    use serde::de::{Deserializer, Error};
    use serde::ser::Serializer;
    use serde::{Deserialize, Serialize};

    #[derive(Serialize, Deserialize)]
    struct StoredForm {
        artifact: Stored,
        no_spirv: Option<String>,
    }

    impl From<&Form> for StoredForm {
        fn from(form: &Form) -> StoredForm {
            StoredForm { artifact: form.artifact.clone().into(), no_spirv: form.no_spirv.clone() }
        }
    }

    impl StoredForm {
        fn form<E: Error>(self) -> Result<Form, E> {
            let artifact = Artifact::try_from(self.artifact).map_err(E::custom)?;
            Ok(Form { artifact, no_spirv: self.no_spirv })
        }
    }

    pub mod form {
        use super::*;

        pub fn serialize<S: Serializer>(form: &Form, to: S) -> Result<S::Ok, S::Error> {
            StoredForm::from(form).serialize(to)
        }

        pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Form, D::Error> {
            StoredForm::deserialize(from)?.form()
        }
    }

    pub mod optional {
        use super::*;

        pub fn serialize<S: Serializer>(form: &Option<Form>, to: S) -> Result<S::Ok, S::Error> {
            form.as_ref().map(StoredForm::from).serialize(to)
        }

        pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Form>, D::Error> {
            Option::<StoredForm>::deserialize(from)?.map(StoredForm::form).transpose()
        }
    }
}
