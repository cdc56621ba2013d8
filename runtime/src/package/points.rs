//! A package's shader on points without a scene.
//!
//! In: a shader, values, the grid. Out: what [`crate::shade`] runs, and what it supplies. It must not know devices.

use super::take::{accept, on_road};
use super::{Error, Shader};
use crate::attributes::as_binding;
use crate::grid::Grid;
use crate::roads::Road;
use crate::supplies::{Given, PointData, Supplies};
use crate::textures::Library;
use oslcl_compiler::{Artifact, Binding, Userdata};

impl Shader {
    /// The function that [`crate::shade::run_supplied`] runs, whose outputs are those of [`crate::shade::default_outputs`], and
    /// what it is supplied with. `values` are for parameters: of those that are built into the code, only the same values.
    pub fn at_points(
        &self,
        values: &[(String, Binding)],
        grid: &Grid,
        road: Road,
        library: &Library,
    ) -> Result<(Artifact, Supplies), Error> {
        let shader = || self.name.clone();
        let form = self.points.as_ref().ok_or_else(|| Error::NoPoints {
            shader: shader(),
            cause: self.no_points.clone().unwrap_or_else(|| "it was left out".to_owned()),
        })?;
        let mut supplies = Supplies::default();
        for (name, value) in values {
            supplies.interactive.extend(accept(self, name, value)?.map(|full| (full, value.clone())));
        }
        if let Some(cause) = self.facts.iter().find_map(|fact| fact.changed(library)) {
            return Err(Error::Fact { shader: shader(), cause });
        }
        let artifact = on_road(self, form, road)?;
        let known = grid.attributes();
        for slot in &artifact.inputs.userdata {
            let Some(value) = known.answer(&slot.name) else { continue };
            let declared = Userdata { name: slot.name.clone(), ty: slot.resolved, sometimes: true, same_as: None };
            supplies.userdata.push(PointData { declared, given: Given::Constant(as_binding(value)) });
        }
        Ok((artifact, supplies))
    }
}
