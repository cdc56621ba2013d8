//! The table of lights: emissive triangles, chosen in proportion to their power.
//!
//! In: triangles and what they emit. Out: arrays as kernels/lights.h reads them.

use super::AliasTable;
use crate::choices::LightChoice;
use crate::scene::MaterialId;
use glam::DVec3;

/// Numbers of a light, and where in them its radiance and its choice stand.
const LIGHT_REALS: usize = 14;
const RADIANCE: usize = 9;
const DENSITY: usize = 12;
const SHARE: usize = 13;
/// Words of a light.
const LIGHT_WORDS: usize = 4;

/// What a material's surfaces emit on their front side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emission {
    /// Nothing.
    None,
    /// The same radiance everywhere, W / (m^2 sr) per channel.
    Constant([f64; 3]),
    /// What its shader says at each point; the queue that its rays wait in.
    Varying {
        /// Number of the queue.
        queue: u32,
    },
}

/// Emissive triangles.
#[derive(Debug, Default)]
pub struct Lights {
    /// 14 numbers a light: corner, two edges, radiance, density, share of its cell.
    pub reals: Vec<f64>,
    /// 4 words a light: alias, triangle in leaf order, instance, queue (all ones: none).
    pub words: Vec<u32>,
    areas: Vec<f64>,
    numbers: Vec<u32>,
    materials: Vec<MaterialId>,
}

impl Lights {
    /// How many.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// The materials with a shader that has to be asked.
    pub fn varying_materials(&self) -> Vec<MaterialId> {
        let varying = |i: &usize| self.words[LIGHT_WORDS * i + 3] != u32::MAX;
        let mut out: Vec<MaterialId> = (0..self.len()).filter(varying).map(|i| self.materials[i]).collect();
        out.sort_by_key(|m| m.0);
        out.dedup();
        out
    }

    pub(super) fn add(
        &mut self,
        [a, b, c]: [DVec3; 3],
        emission: Emission,
        material: MaterialId,
        number: u32,
        instance: u32,
    ) {
        let (radiance, queue) = match emission {
            Emission::Constant(rgb) => (rgb, u32::MAX),
            Emission::Varying { queue } => ([1.0; 3], queue),
            Emission::None => return,
        };
        let (e1, e2) = (b - a, c - a);
        self.areas.push(e1.cross(e2).length() / 2.0);
        self.reals.extend([a, e1, e2].iter().flat_map(|v| v.to_array()));
        self.reals.extend(radiance);
        self.reals.extend([0.0, 1.0]);
        self.words.extend([0, number, instance, queue]);
        self.numbers.push(number);
        self.materials.push(material);
    }

    /// When the tree stands: finds the triangles' places in leaf order, and chooses by the constant radiances.
    pub(super) fn finish(&mut self, triangle_ids: &[u32], choice: LightChoice) {
        if self.is_empty() {
            return;
        }
        let most = triangle_ids.iter().copied().max().unwrap_or(0) as usize;
        let mut place = vec![0u32; most + 1];
        for (leaf, number) in triangle_ids.iter().enumerate() {
            place[*number as usize] = leaf as u32;
        }
        for (i, number) in self.numbers.iter().enumerate() {
            self.words[LIGHT_WORDS * i + 1] = place[*number as usize];
        }
        self.choose(&self.radiance(), choice);
    }

    /// The mean of the channels of each light's radiance; 1 where a shader has to be asked.
    pub fn radiance(&self) -> Vec<f64> {
        self.reals.chunks(LIGHT_REALS).map(|light| light[RADIANCE..][..3].iter().sum::<f64>() / 3.0).collect()
    }

    /// Makes the choice among the lights; their power is radiance times area. `radiance`: the mean of the channels per light.
    pub fn choose(&mut self, radiance: &[f64], choice: LightChoice) {
        let usable = |x: f64| if x.is_finite() && x > 0.0 { x } else { 0.0 };
        let power = self.areas.iter().zip(radiance).map(|(a, r)| usable(a * usable(*r)));
        let weights: Vec<f64> = match choice {
            LightChoice::Power => power.collect(),
            LightChoice::Uniform => power.map(|p| if p > 0.0 { 1.0 } else { 0.0 }).collect(),
        };
        let table = AliasTable::new(&weights);
        for (i, area) in self.areas.iter().enumerate() {
            let light = &mut self.reals[LIGHT_REALS * i..][..LIGHT_REALS];
            light[DENSITY] = if *area > 0.0 { table.probability[i] / area } else { 0.0 };
            light[SHARE] = table.share[i];
            self.words[LIGHT_WORDS * i] = table.alias[i];
        }
    }
}
