//! The numbers that kernels are given: a scene's settings as words, its camera and the like as reals.
//!
//! In: scene, plan, geometry. Out: what the buffers of settings and constants hold. It must not know devices.

use super::Spread;
use crate::accel::{Geometry, row_major};
use crate::plan::{Constant, Effect, Plan, Setting};
use crate::scene::{Filter, Scene};

/// Where a setting stands in the buffer; the table has them all.
pub(super) fn place(setting: Setting) -> usize {
    Setting::ALL.iter().take_while(|(s, _)| *s != setting).count()
}

/// The seed's halves mixed: kernels take 32 bits.
pub(super) fn folded(seed: u64) -> u32 {
    (seed ^ (seed >> 32).wrapping_mul(0x9e37_79b9)) as u32
}

/// The settings as a render begins.
pub(super) fn settings(scene: &Scene, plan: &Plan, geometry: &Geometry, spread: Spread) -> [u32; Setting::ALL.len()] {
    Setting::ALL.map(|(setting, _)| match setting {
        Setting::Width => scene.film.width,
        Setting::Height => scene.film.height,
        Setting::Seed => folded(scene.integrator.seed),
        Setting::MaxDepth => scene.integrator.max_depth,
        Setting::RouletteFrom => scene.integrator.roulette_from.unwrap_or(u32::MAX),
        Setting::Lights => geometry.lights.len() as u32,
        Setting::Filter => match scene.filter {
            Filter::Tent if plan.is_asked(Effect::TentFilter) => 1,
            Filter::Middle if plan.is_asked(Effect::MiddleFilter) => 2,
            _ => 0,
        },
        Setting::TwoSided => u32::from(plan.is_asked(Effect::TwoSidedEmission)),
        Setting::Split => u32::from(plan.is_asked(Effect::SplitLobes)),
        Setting::Paths => spread.paths,
        Setting::SlotsPerPixel => spread.slots_per_pixel,
        Setting::StripeBits => spread.stripe_bits,
        Setting::Slots | Setting::PixelFirst | Setting::SampleFirst | Setting::SampleEnd => 0,
    })
}

/// The constants.
pub(super) fn constants(scene: &Scene, plan: &Plan) -> Vec<f64> {
    let camera = &scene.camera;
    let to_world = camera.to_world();
    let [right, up, forward] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
    let tangent = (camera.hfov_degrees.to_radians() / 2.0).tan();
    let aspect = f64::from(scene.film.height) / f64::from(scene.film.width);
    let mut out = vec![0.0; Constant::total()];
    let mut put = |constant: Constant, values: &[f64]| out[constant.offset()..][..values.len()].copy_from_slice(values);
    put(Constant::CameraPosition, &camera.origin.to_array());
    put(Constant::CameraForward, &forward.to_array());
    put(Constant::CameraRight, &(right * tangent).to_array());
    put(Constant::CameraUp, &(up * tangent * aspect).to_array());
    put(Constant::LensRight, &right.to_array());
    put(Constant::LensUp, &up.to_array());
    put(Constant::LensRadius, &[camera.lens_radius]);
    put(Constant::FocusDistance, &[camera.focus_distance]);
    put(Constant::Environment, &plan.constant_environment);
    let share = match plan.is_asked(Effect::EnvironmentSampling) {
        true if plan.is_asked(Effect::Lights) => 0.5,
        true => 1.0,
        false => 0.0,
    };
    put(Constant::EnvironmentShare, &[share]);
    if plan.has(Effect::CameraSpace) {
        put(Constant::CameraSpace, &[to_world, to_world.inverse()].map(|map| row_major(&map)).concat());
    }
    out
}
