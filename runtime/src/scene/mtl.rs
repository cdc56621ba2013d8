//! Materials of OBJ libraries as shipped shaders. docs/scene.md has the same table.
//!
//! In: what tobj read of a .mtl file. Out: materials. It must not know scenes or meshes.

use super::{Material, ParamValue};

/// First match: Ke > 0 is `emitter`; d < 0.5 or illum 4, 6, 7, 9 is `glass`; Kd black and Ks >= 0.3 is `metal`;
/// Ks > 0 and illum not 0 or 1 is `plastic`; the rest is `matte`.
pub(super) fn convert(mtl: &tobj::Material) -> Material {
    let diffuse = mtl.diffuse.unwrap_or([0.6; 3]);
    let specular = mtl.specular.unwrap_or([0.0; 3]);
    let emitted = mtl.emissive.unwrap_or([0.0; 3]);
    let illum = mtl.illumination_model;
    let ior = mtl.optical_density.filter(|n| (1.01..=3.0).contains(n)).unwrap_or(1.5);
    let largest = |colour: [f32; 3]| colour.into_iter().fold(0.0, f32::max);
    let number = |name: &str, value: f32| (name.to_string(), ParamValue::Float(f64::from(value)));
    let colour = |name: &str, value: [f32; 3]| {
        (name.to_string(), ParamValue::Floats(value.iter().map(|v| f64::from(*v)).collect()))
    };
    let (shader, params) = if largest(emitted) > 0.0 {
        ("emitter", vec![colour("radiance", emitted)])
    } else if mtl.dissolve.is_some_and(|d| d < 0.5) || matches!(illum, Some(4 | 6 | 7 | 9)) {
        ("glass", vec![number("ior", ior)])
    } else if largest(diffuse) < 0.02 && largest(specular) >= 0.3 {
        let (eta, k) = conductor(specular);
        ("metal", vec![colour("eta", eta), colour("k", k), number("roughness", roughness(mtl.shininess))])
    } else if largest(specular) > 0.0 && !matches!(illum, Some(0 | 1)) {
        let roughness = roughness(mtl.shininess);
        ("plastic", vec![colour("Cs", diffuse), number("ior", ior), number("roughness", roughness)])
    } else {
        ("matte", vec![colour("Cs", diffuse)])
    };
    let mut material = Material::of_shipped(&mtl.name, shader);
    material.params = params;
    material
}

/// Perceived roughness of a Blinn-Phong exponent: alpha = sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5.2, for
/// Blinn-Phong against Beckmann), and roughness is its root.
fn roughness(shininess: Option<f32>) -> f32 {
    let exponent = shininess.filter(|s| s.is_finite()).unwrap_or(100.0).max(0.0);
    (2.0 / (exponent + 2.0)).sqrt().sqrt()
}

/// Index and extinction of a reflectivity (Gulbrandsen 2014, equations 6 to 9, halfway between the edge tints).
fn conductor(reflectivity: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let r = reflectivity.map(|r| r.clamp(0.0, 0.99));
    let eta = r.map(|r| 0.5 * (1.0 - r) / (1.0 + r) + 0.5 * (1.0 + r.sqrt()) / (1.0 - r.sqrt()));
    let k = [0, 1, 2].map(|i| {
        let (r, n): (f32, f32) = (r[i], eta[i]);
        (((n + 1.0).powi(2) * r - (n - 1.0).powi(2)).max(0.0) / (1.0 - r)).sqrt()
    });
    (eta, k)
}
