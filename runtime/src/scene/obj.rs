//! OBJ meshes, and their material libraries as parameters of shipped shaders.
//!
//! In: the text of a file. Out: one mesh per material. It must not know scenes. Materials: see `mtl`.

use super::error::{Error, MeshFile};
use super::{Material, Mesh, VertexData, mtl};
use glam::{Vec2, Vec3};
use std::cell::RefCell;
use std::io::{self, BufRead};
use std::path::Path;

/// What an OBJ file holds.
pub(super) struct Obj {
    /// One mesh for each material in use, with its index into `materials`, in the order of first use.
    pub parts: Vec<(Mesh, Option<usize>)>,
    /// All materials of the libraries.
    pub materials: Vec<Material>,
    /// The first library that could not be read; its materials are missing.
    pub library_error: Option<Error>,
}

/// A named piece of a file.
pub(super) struct Object {
    /// Its triangles, named as in the file.
    pub mesh: Mesh,
    /// The name of its material in the libraries that could be read.
    pub material: Option<String>,
}

/// Reads a file's bytes object by object; libraries give names only, and may be missing.
pub(super) fn objects(bytes: &[u8], path: &Path) -> Result<Vec<Object>, Error> {
    let Read { models, materials, .. } = read(bytes, path)?;
    let object = |model: tobj::Model| Object {
        mesh: Mesh { name: model.name, ..convert(&model.mesh) },
        material: model.mesh.material_id.and_then(|id| materials.get(id)).map(|m| m.name.clone()),
    };
    Ok(models.into_iter().map(object).filter(|o| !o.mesh.triangles.is_empty()).collect())
}

/// A file as its reader hands it over.
struct Read {
    models: Vec<tobj::Model>,
    materials: Vec<tobj::Material>,
    library_error: Option<Error>,
}

fn read(bytes: &[u8], path: &Path) -> Result<Read, Error> {
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let folder = path.parent().unwrap_or(Path::new(""));
    let library_error = RefCell::new(None);
    let library = |file: &Path| load_library(&folder.join(file), &library_error);
    let mut reader = Counting { bytes, line: 0 };
    let loaded = tobj::load_obj_buf(&mut reader, &options, library);
    let (models, materials) = loaded.map_err(|error| complain(error, bytes, reader.line, path))?;
    Ok(Read { models, materials: materials.unwrap_or_default(), library_error: library_error.into_inner() })
}

/// Reads a file's bytes; material libraries are looked for beside `path`.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Obj, Error> {
    let Read { models, materials, library_error } = read(bytes, path)?;
    let mut parts: Vec<(Mesh, Option<usize>)> = Vec::new();
    for model in models {
        let id = model.mesh.material_id;
        let mesh = convert(&model.mesh);
        match parts.iter_mut().find(|(_, other)| *other == id) {
            Some((whole, _)) => append(whole, mesh),
            None => parts.push((mesh, id)),
        }
    }
    parts.retain(|(mesh, _)| !mesh.triangles.is_empty());
    let materials = materials.iter().map(mtl::convert).collect();
    Ok(Obj { parts, materials, library_error })
}

/// All parts as one mesh.
pub(super) fn merge(parts: Vec<(Mesh, Option<usize>)>) -> Mesh {
    let mut whole = Mesh::default();
    for (mesh, _) in parts {
        append(&mut whole, mesh);
    }
    whole
}

fn convert(mesh: &tobj::Mesh) -> Mesh {
    let triples = |list: &[f32]| list.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    let positions = triples(&mesh.positions);
    // A file that gives some corners a normal and others none has none as a whole.
    let mut normals = triples(&mesh.normals);
    let mut uvs: Vec<Vec2> = mesh.texcoords.chunks_exact(2).map(Vec2::from_slice).collect();
    if normals.len() != positions.len() {
        normals.clear();
    }
    if uvs.len() != positions.len() {
        uvs.clear();
    }
    let triangles = mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mut data = Vec::new();
    if mesh.vertex_color.len() == mesh.positions.len() && !mesh.vertex_color.is_empty() {
        data.push(VertexData { name: "Cd".to_string(), channels: 3, values: mesh.vertex_color.clone() });
    }
    Mesh { positions, normals, uvs, triangles, data, ..Mesh::default() }
}

/// Joins two meshes. Where one has no normals it gets zeros, which mean "unknown"; where one has no uv or no data of
/// a name, both lose them.
fn append(whole: &mut Mesh, mut part: Mesh) {
    let base = whole.positions.len() as u32;
    if base == 0 {
        *whole = part;
        return;
    }
    if whole.normals.is_empty() != part.normals.is_empty() {
        whole.normals.resize(whole.positions.len(), Vec3::ZERO);
        part.normals.resize(part.positions.len(), Vec3::ZERO);
    }
    if whole.uvs.is_empty() || part.uvs.is_empty() {
        whole.uvs.clear();
        part.uvs.clear();
    }
    // Data that one of them lacks is nobody's.
    whole.data.retain(|d| part.data.iter().any(|p| p.name == d.name && p.channels == d.channels));
    for data in &mut whole.data {
        let other = part.data.iter().find(|p| p.name == data.name && p.channels == data.channels);
        data.values.extend(other.map(|p| p.values.as_slice()).unwrap_or_default());
    }
    whole.positions.append(&mut part.positions);
    whole.normals.append(&mut part.normals);
    whole.uvs.append(&mut part.uvs);
    whole.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + base)));
}

/// Reads a material library; the first error of all is kept, for tobj's own names no file.
fn load_library(path: &Path, first_error: &RefCell<Option<Error>>) -> tobj::MTLLoadResult {
    let keep = |error| {
        first_error.borrow_mut().get_or_insert(error);
    };
    let bytes = std::fs::read(path).map_err(|cause| {
        keep(Error::Unreadable { what: "material library", path: path.to_path_buf(), cause: cause.to_string() });
        tobj::LoadError::OpenFileFailed
    })?;
    let mut reader = Counting { bytes: &bytes, line: 0 };
    tobj::load_mtl_buf(&mut reader).inspect_err(|error| {
        let at = MeshFile { path: path.to_path_buf(), line: Some(reader.line) };
        keep(Error::Malformed { at, format: "MTL", cause: error.to_string() });
    })
}

/// tobj's errors have no line: the first bad reference is looked for, and otherwise the line is the last one read.
fn complain(error: tobj::LoadError, bytes: &[u8], line: usize, path: &Path) -> Error {
    use tobj::LoadError::{
        FaceColorOutOfBounds, FaceNormalOutOfBounds, FaceTexCoordOutOfBounds, FaceVertexOutOfBounds,
    };
    let out_of_bounds =
        matches!(error, FaceVertexOutOfBounds | FaceNormalOutOfBounds | FaceTexCoordOutOfBounds | FaceColorOutOfBounds);
    if out_of_bounds && let Some(found) = bad_reference(bytes, path) {
        return found;
    }
    let at = MeshFile { path: path.to_path_buf(), line: (!out_of_bounds).then_some(line) };
    Error::Malformed { at, format: "OBJ", cause: error.to_string() }
}

/// The first corner of a face that refers to something the file doesn't have.
fn bad_reference(bytes: &[u8], path: &Path) -> Option<Error> {
    let text = String::from_utf8_lossy(bytes);
    let total = |keyword: &str| text.lines().filter(|l| l.split_whitespace().next() == Some(keyword)).count();
    let lists = [("vertex", total("v")), ("texture coordinate", total("vt")), ("normal", total("vn"))];
    let faces = text.lines().enumerate().filter(|(_, l)| l.split_whitespace().next() == Some("f"));
    for (face, (line, words)) in faces.enumerate() {
        for corner in words.split_whitespace().skip(1) {
            for (index, (what, count)) in corner.split('/').zip(lists) {
                let Ok(index) = index.parse::<i64>() else { continue };
                if index == 0 || index.unsigned_abs() > count as u64 {
                    let at = MeshFile { path: path.to_path_buf(), line: Some(line + 1) };
                    return Some(Error::IndexOutOfRange { at, face, what, index, count, first: 1 });
                }
            }
        }
    }
    None
}

/// Hands out one line at a time and counts them.
struct Counting<'a> {
    bytes: &'a [u8],
    line: usize,
}

impl io::Read for Counting<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.bytes.read(buffer)
    }
}

impl BufRead for Counting<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.bytes)
    }

    fn consume(&mut self, amount: usize) {
        // Lines are consumed whole, the last one perhaps without its end.
        self.line += usize::from(amount > 0);
        self.bytes = &self.bytes[amount..];
    }
}
