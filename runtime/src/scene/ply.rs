//! PLY meshes: ASCII and binary of both byte orders.
//!
//! In: the bytes of a file. Out: a mesh. It must not know scenes.
//! Read are x y z, nx ny nz, texture coordinates named u v, s t or texture_u texture_v, and faces of any length. All other
//! numbers of vertices become data by their names.

use super::error::{Error, MeshFile};
use super::{Mesh, VertexData, geometry};
use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};
use std::io::ErrorKind;
use std::path::Path;

const U_NAMES: [&str; 4] = ["u", "s", "texture_u", "texture_s"];
/// Properties whose bytes stand for 0 to 1.
const COLOR_NAMES: [&str; 4] = ["red", "green", "blue", "alpha"];
const V_NAMES: [&str; 4] = ["v", "t", "texture_v", "texture_t"];

/// Reads a mesh; `path` is for messages.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Mesh, Error> {
    let malformed = |cause: &str| {
        let at = MeshFile { path: path.to_path_buf(), line: None };
        Error::Malformed { at, format: "PLY", cause: cause.to_string() }
    };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skip>::new().read_header(&mut reader).map_err(|e| complain(e, path, "the header"))?;
    let mut vertices: Vec<Vertex> = Vec::new();
    let mut faces: Vec<Face> = Vec::new();
    let mut mesh = Mesh::default();
    let (mut has_normals, mut has_uvs) = (false, false);
    let mut extra: Vec<(String, bool)> = Vec::new();
    for (name, element) in &header.elements {
        let what = format!("element `{name}` with {} entries", element.count);
        let failed = |e| complain(e, path, &what);
        match name.as_str() {
            "vertex" => {
                if !["x", "y", "z"].iter().all(|name| has(element, &[name])) {
                    return Err(malformed("element `vertex` has no x, y and z"));
                }
                has_normals = ["nx", "ny", "nz"].iter().all(|name| has(element, &[name]));
                has_uvs = has(element, &U_NAMES) && has(element, &V_NAMES);
                let more = element.properties.iter().filter(|(name, _)| !is_known(name));
                extra = more
                    .map(|(name, def)| (name.clone(), matches!(def.data_type, PropertyType::Scalar(ScalarType::UChar))))
                    .collect();
                vertices = Parser::new().read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
            }
            "face" => {
                if !has(element, &["vertex_indices", "vertex_index"]) {
                    return Err(malformed("element `face` has no list vertex_indices"));
                }
                faces = Parser::new().read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
            }
            _ => {
                let parser = Parser::<Skip>::new();
                parser.read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
            }
        }
    }
    mesh.positions = vertices.iter().map(|v| v.position).collect();
    if has_normals {
        mesh.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if has_uvs {
        mesh.uvs = vertices.iter().map(|v| v.uv).collect();
    }
    for (i, (name, bytes)) in extra.into_iter().enumerate() {
        // Bytes of colours stand for 0 to 1.
        let scale = if bytes && COLOR_NAMES.contains(&name.as_str()) { 1.0 / 255.0 } else { 1.0 };
        let values: Option<Vec<f32>> = vertices.iter().map(|v| v.extra.get(i).copied().flatten()).collect();
        if let Some(mut values) = values {
            values.iter_mut().for_each(|v| *v *= scale);
            mesh.data.push(VertexData { name, channels: 1, values });
        }
    }
    mesh.data.extend(color(&mesh.data));
    mesh.triangles = triangles(&faces, vertices.len(), path)?;
    Ok(mesh)
}

/// `red`, `green` and `blue` as one colour, `Cd`.
fn color(data: &[VertexData]) -> Option<VertexData> {
    let find = |name: &str| data.iter().find(|d| d.name == name).map(|d| &d.values);
    let (red, green, blue) = (find("red")?, find("green")?, find("blue")?);
    let values = red.iter().zip(green).zip(blue).flat_map(|((r, g), b)| [*r, *g, *b]).collect();
    Some(VertexData { name: "Cd".to_string(), channels: 3, values })
}

/// Whether a property of vertices has its own place in a mesh.
fn is_known(name: &str) -> bool {
    ["x", "y", "z", "nx", "ny", "nz"].contains(&name) || U_NAMES.contains(&name) || V_NAMES.contains(&name)
}

fn triangles(faces: &[Face], vertices: usize, path: &Path) -> Result<Vec<[u32; 3]>, Error> {
    let mut triangles = Vec::with_capacity(faces.len());
    let mut polygon = Vec::new();
    for (face, Face { indices }) in faces.iter().enumerate() {
        let at = || MeshFile { path: path.to_path_buf(), line: None };
        if indices.len() < 3 {
            let cause = format!("face {face} has {} vertices", indices.len());
            return Err(Error::Malformed { at: at(), format: "PLY", cause });
        }
        polygon.clear();
        for index in indices {
            let known = u32::try_from(*index).ok().filter(|i| (*i as usize) < vertices);
            polygon.push(known.ok_or_else(|| Error::IndexOutOfRange {
                at: at(),
                face,
                what: "vertex",
                index: *index,
                count: vertices,
                first: 0,
            })?);
        }
        geometry::fan(&polygon, &mut triangles);
    }
    Ok(triangles)
}

fn has(element: &ElementDef, names: &[&str]) -> bool {
    element.properties.iter().any(|(name, _)| names.contains(&name.as_str()))
}

fn complain(error: ParseError, path: &Path, what: &str) -> Error {
    let at = MeshFile { path: path.to_path_buf(), line: error.line() };
    if error.kind() == ErrorKind::UnexpectedEof {
        return Error::Truncated { at: MeshFile { line: None, ..at }, cause: format!("it ends within {what}") };
    }
    Error::Malformed { at, format: "PLY", cause: shorten(&error.to_string()) }
}

/// What the parser says, without the line's number, which stands elsewhere, and without its grammar. Of a line that it can't
/// read the first word that is no number is shown, such as `nan`, which it does not take.
fn shorten(text: &str) -> String {
    let cause = text.strip_prefix("Line ").and_then(|t| t.split_once(": ")).map_or(text, |(_, cause)| cause);
    // The parser quotes the line between these.
    let quoted =
        cause.split_once("String: '").and_then(|(_, t)| t.split('\n').next()).map(|t| t.trim_end_matches('\''));
    let Some(line) = quoted else { return cause.lines().next().unwrap_or(cause).to_string() };
    let line: String = line.trim().chars().take(80).collect();
    if !cause.contains("element line") {
        return format!("{} `{line}`", cause.lines().next().unwrap_or_default());
    }
    let finite = |word: &&str| word.parse::<f64>().is_ok_and(f64::is_finite);
    match line.split_whitespace().find(|word| !finite(word)) {
        Some(word) => format!("`{word}` is not a finite number in the line `{line}`"),
        None => format!("the line `{line}` does not have the values that the header announces"),
    }
}

/// An element that nobody asks for.
struct Skip;

impl PropertyAccess for Skip {
    fn new() -> Self {
        Skip
    }
}

struct Vertex {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    /// The other properties in the file's order; `None` for lists.
    extra: Vec<Option<f32>>,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex { position: Vec3::ZERO, normal: Vec3::ZERO, uv: Vec2::ZERO, extra: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Char(v) => Some(f32::from(v)),
            Property::UChar(v) => Some(f32::from(v)),
            Property::Short(v) => Some(f32::from(v)),
            Property::UShort(v) => Some(f32::from(v)),
            Property::Int(v) => Some(v as f32),
            Property::UInt(v) => Some(v as f32),
            Property::Float(v) => Some(v),
            Property::Double(v) => Some(v as f32),
            _ => None,
        };
        let slot = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            name if U_NAMES.contains(&name) => &mut self.uv.x,
            name if V_NAMES.contains(&name) => &mut self.uv.y,
            _ => {
                self.extra.push(value);
                return PropertyAccessResult::Set;
            }
        };
        let Some(value) = value else { return PropertyAccessResult::UnsupportedType };
        *slot = value;
        PropertyAccessResult::Set
    }
}

struct Face {
    indices: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Face { indices: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}
