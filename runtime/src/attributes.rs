//! What `getattribute` finds in a render: the camera, and the attributes of the scene and its objects.
//!
//! In: a scene. Out: for a material what is known when it is compiled, and the names of what differs from object to object;
//! those values by instance. Objects are looked at first: instance, mesh, material, scene. It must not know devices.

use crate::scene::{Attributes as Named, ParamValue, Scene};
use oslcl_compiler::Binding;
use oslcl_compiler::attributes::{Attribute, Attributes, Value, asked};
use std::collections::BTreeSet;

/// The attributes that the shader of this material finds. `of`: the material of the surfaces that it runs on.
pub(crate) fn of_material(scene: &Scene, of: usize) -> Attributes {
    let mut out = Attributes { list: camera(scene), ..Attributes::default() };
    let instances: Vec<usize> = (0..scene.instances.len()).filter(|i| material(scene, *i) == of).collect();
    let mut names: BTreeSet<&str> = BTreeSet::new();
    for instance in &instances {
        let placed = &scene.instances[*instance];
        let own = placed.attributes.iter().chain(&scene.meshes[placed.mesh.0 as usize].attributes);
        names.extend(own.map(|(name, _)| name.as_str()));
    }
    let outer = scene.materials[of].attributes.iter().chain(&scene.attributes);
    names.extend(outer.map(|(name, _)| name.as_str()));
    for name in names {
        let mut values = instances.iter().map(|i| of_instance(scene, *i, name));
        let first = match values.next() {
            Some(first) => first,
            // Of the environment.
            None => find(&scene.materials[of].attributes, name).or_else(|| find(&scene.attributes, name)),
        };
        match first {
            _ if values.any(|v| v != first) => {
                out.varying.push(name.to_owned());
                let all = instances.iter().filter_map(|i| of_instance(scene, *i, name));
                if let Some(values) = texts_or_ints(all) {
                    out.values.push((name.to_owned(), values));
                }
            }
            Some(value) => add(&mut out.list, "", name, value),
            None => {}
        }
    }
    for (name, value) in &scene.attributes {
        add(&mut out.list, "global", name, value);
    }
    for material in &scene.materials {
        material.attributes.iter().for_each(|(name, value)| add(&mut out.list, &material.name, name, value));
    }
    for mesh in &scene.meshes {
        mesh.attributes.iter().for_each(|(name, value)| add(&mut out.list, &mesh.name, name, value));
    }
    out
}

/// Most values of an attribute that shaders make texts of.
const MAX_VALUES: usize = 256;

/// Each of these values once, if all are strings or all are ints.
fn texts_or_ints<'a>(values: impl Iterator<Item = &'a ParamValue>) -> Option<Vec<Value>> {
    let mut out: Vec<Value> = Vec::new();
    for value in values {
        let value = match value {
            ParamValue::Int(v) => Value::Int(i32::try_from(*v).ok()?),
            ParamValue::Str(s) => Value::Str(s.clone()),
            _ => return None,
        };
        if out.first().is_some_and(|first| first.ty() != value.ty()) {
            return None;
        }
        if !out.contains(&value) {
            out.push(value);
        }
        if out.len() > MAX_VALUES {
            return None;
        }
    }
    Some(out)
}

fn material(scene: &Scene, instance: usize) -> usize {
    scene.instances[instance].material.0 as usize
}

fn find<'a>(list: &'a Named, name: &str) -> Option<&'a ParamValue> {
    list.iter().rev().find(|(n, _)| n == name).map(|(_, value)| value)
}

/// The value of an attribute on a placed mesh.
pub(crate) fn of_instance<'a>(scene: &'a Scene, instance: usize, name: &str) -> Option<&'a ParamValue> {
    let placed = &scene.instances[instance];
    let mesh = &scene.meshes[placed.mesh.0 as usize];
    let material = &scene.materials[placed.material.0 as usize];
    let lists = [&placed.attributes, &mesh.attributes, &material.attributes, &scene.attributes];
    lists.into_iter().find_map(|list| find(list, name))
}

/// The value for userdata that stands for an attribute ([`oslcl_compiler::attributes::asked`]), on a placed mesh.
pub(crate) fn at_instance(scene: &Scene, instance: usize, userdata: &str) -> Option<Binding> {
    let (name, _) = asked(userdata)?;
    let mut known = Attributes { list: camera(scene), ..Attributes::default() };
    if let Some(value) = of_instance(scene, instance, name) {
        add(&mut known.list, "", name, value);
    }
    known.answer(userdata).map(as_binding)
}

/// What a shader around the scene finds without naming an object.
pub(crate) fn around(scene: &Scene, material: usize) -> Attributes {
    let mut known = Attributes { list: camera(scene), ..Attributes::default() };
    for (name, value) in scene.materials[material].attributes.iter().rev().chain(scene.attributes.iter().rev()) {
        add(&mut known.list, "", name, value);
    }
    known
}

/// A constant as a value to give.
pub(crate) fn as_binding(value: Value) -> Binding {
    match value {
        Value::Int(v) => Binding::Int(i64::from(v)),
        Value::Float(v) => Binding::Float(v),
        Value::Str(s) => Binding::Str(s),
        Value::Triple(v) => Binding::Floats(v.to_vec()),
        Value::Matrix(v) => Binding::Floats(v.to_vec()),
        Value::Array(items) => {
            let (mut numbers, mut texts) = (Vec::new(), Vec::new());
            for item in items {
                match as_binding(item) {
                    Binding::Int(v) => numbers.push(v as f64),
                    Binding::Float(v) => numbers.push(v),
                    Binding::Floats(v) => numbers.extend(v),
                    Binding::Str(s) => texts.push(s),
                    Binding::Strs(list) => texts.extend(list),
                }
            }
            if texts.is_empty() { Binding::Floats(numbers) } else { Binding::Strs(texts) }
        }
    }
}

/// Every string among the attributes, which shaders may print.
pub(crate) fn strings(scene: &Scene) -> Vec<String> {
    let meshes = scene.meshes.iter().flat_map(|m| &m.attributes);
    let instances = scene.instances.iter().flat_map(|i| &i.attributes);
    let materials = scene.materials.iter().flat_map(|m| &m.attributes);
    let mut out = Vec::new();
    for (_, value) in scene.attributes.iter().chain(meshes).chain(instances).chain(materials) {
        match value {
            ParamValue::Str(s) => out.push(s.clone()),
            ParamValue::Strs(list) => out.extend(list.iter().cloned()),
            _ => {}
        }
    }
    out
}

/// Adds a value in every type that it can be read as: a list of numbers does not say whether it is a color.
fn add(list: &mut Vec<Attribute>, object: &str, name: &str, value: &ParamValue) {
    let mut put = |ty: String, value: Value| {
        list.push(Attribute { object: object.to_owned(), name: name.to_owned(), ty, value });
    };
    let float = |v: &f64| Value::Float(*v);
    match value {
        ParamValue::Int(v) => match i32::try_from(*v) {
            Ok(v) => put("int".into(), Value::Int(v)),
            Err(_) => put("float".into(), Value::Float(*v as f64)),
        },
        ParamValue::Float(v) => put("float".into(), Value::Float(*v)),
        ParamValue::Str(s) => put("string".into(), Value::Str(s.clone())),
        ParamValue::Strs(v) => {
            put(format!("string[{}]", v.len()), Value::Array(v.iter().map(|s| Value::Str(s.clone())).collect()));
        }
        ParamValue::Floats(v) => {
            put(format!("float[{}]", v.len()), Value::Array(v.iter().map(float).collect()));
            match v.as_slice() {
                [x, y, z] => put("color".into(), Value::Triple([*x, *y, *z])),
                v => {
                    if let Ok(m) = <[f64; 16]>::try_from(v) {
                        put("matrix".into(), Value::Matrix(m));
                    }
                }
            }
            if v.iter().all(|x| x.fract() == 0.0 && x.abs() < 2f64.powi(31)) {
                put(format!("int[{}]", v.len()), Value::Array(v.iter().map(|x| Value::Int(*x as i32)).collect()));
            }
        }
    }
}

/// The camera (specification ch. 7.10). Nothing is cut off at any depth, and the shutter is open for an instant.
fn camera(scene: &Scene) -> Vec<Attribute> {
    let size = [scene.film.width, scene.film.height];
    let aspect = f64::from(size[1]) / f64::from(size[0]);
    let floats = |v: &[f64]| Value::Array(v.iter().map(|x| Value::Float(*x)).collect());
    let (near, far) = (0.0, 1e30);
    let all = [
        ("resolution", "int[2]", Value::Array(size.map(|n| Value::Int(n as i32)).to_vec())),
        ("projection", "string", Value::Str("perspective".to_owned())),
        ("fov", "float", Value::Float(scene.camera.hfov_degrees)),
        ("pixelaspect", "float", Value::Float(1.0)),
        ("clip", "float[2]", floats(&[near, far])),
        ("clip_near", "float", Value::Float(near)),
        ("clip_far", "float", Value::Float(far)),
        ("shutter", "float[2]", floats(&[0.0, 0.0])),
        ("shutter_open", "float", Value::Float(0.0)),
        ("shutter_close", "float", Value::Float(0.0)),
        ("screen_window", "float[4]", floats(&[-1.0, -aspect, 1.0, aspect])),
    ];
    let attribute = |(name, ty, value): (&str, &str, Value)| Attribute {
        object: String::new(),
        name: format!("camera:{name}"),
        ty: ty.to_owned(),
        value,
    };
    all.into_iter().map(attribute).collect()
}
