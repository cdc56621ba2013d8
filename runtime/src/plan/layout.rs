//! Where everything lies: fields of path state, buffers, queues, settings, constants, counters. One table each, from which
//! both the kernels' layout.h and the host's bindings come.
//!
//! In: the effects that are on. Out: [`Layout`]. It must not know devices.

use super::effects::Effect::{self, *};
use crate::choices::PathState;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::Range;

/// A field of path state: one number or three in the record of a slot.
struct Field {
    name: &'static str,
    numbers: u32,
    /// Any of these calls for it; none: always there.
    needs: &'static [Effect],
    /// May be kept in 16 bits, where the user wants that: numbers whose range no scene's units or lights decide, and whose rounding
    /// moves a path's weight by a part in 2,000, not its place. Directions, places, radiance and densities may not.
    half: bool,
}

const fn field(name: &'static str, numbers: u32, needs: &'static [Effect]) -> Field {
    Field { name, numbers, needs, half: false }
}

const fn short(name: &'static str, numbers: u32, needs: &'static [Effect]) -> Field {
    Field { name, numbers, needs, half: true }
}

/// Bit of a field's place: it is one of the halves behind the reals (kernels/context.h).
const FIELD_HALF: u32 = 0x8000_0000;

const DIRECT: &[Effect] = &[Lights, EnvironmentSampling];
const FACETS: &[Effect] = &[LobeWard, LobeMicrofacet, LobeConductor, LobeDielectric, LobeGeneralizedSchlick];
const DIRECTED: &[Effect] =
    &[LobeWard, LobeMicrofacet, LobeConductor, LobeDielectric, LobeGeneralizedSchlick, LobeChiangHair];
const ROUGH: &[Effect] = &[
    LobeWard,
    LobeMicrofacet,
    LobeConductor,
    LobePhong,
    LobeOrenNayar,
    LobeOrenNayarDiffuse,
    LobeBurleyDiffuse,
    LobeDielectric,
    LobeGeneralizedSchlick,
    LobeSheen,
    LobeChiangHair,
];
const BENDING: &[Effect] =
    &[LobeMicrofacet, LobeReflection, LobeRefraction, LobeDielectric, LobeGeneralizedSchlick, LobeChiangHair];
const TINTED: &[Effect] = &[LobeConductor, LobeDielectric, LobeGeneralizedSchlick, LobeChiangHair];

/// Fields of reals.
const REALS: &[Field] = &[
    field("ray_o", 3, &[]),
    field("ray_d", 3, &[]),
    short("beta", 3, &[]),
    field("radiance", 3, &[]),
    field("pdf", 1, DIRECT),
    field("hole", 1, &[Holdout]),
    field("hit_u", 1, &[Surfaces]),
    field("hit_v", 1, &[Surfaces]),
    field("hit_t", 1, &[Lights]),
    field("point", 3, &[Surfaces]),
    field("offset", 3, &[Surfaces]),
    field("lobe_N", 3, &[Surfaces]),
    field("lobe_T", 3, DIRECTED),
    short("lobe_ax", 1, ROUGH),
    short("lobe_ay", 1, FACETS),
    short("lobe_eta", 1, BENDING),
    short("lobe_c0", 3, TINTED),
    short("lobe_c1", 3, TINTED),
    short("lobe_c2", 3, &[LobeGeneralizedSchlick, LobeChiangHair]),
    short("lobe_c3", 3, &[LobeGeneralizedSchlick, LobeChiangHair]),
    short("lobe_exponent", 1, &[LobeGeneralizedSchlick]),
    short("lobe_c4", 3, &[LobeChiangHair]),
    short("lobe_c5", 3, &[LobeChiangHair]),
    short("lobe_film", 1, &[LobeThinFilm]),
    short("lobe_film_ior", 1, &[LobeThinFilm]),
    field("shadow_o", 3, DIRECT),
    field("shadow_d", 3, DIRECT),
    field("shadow_t", 1, DIRECT),
    field("shadow_L", 3, DIRECT),
    field("cone_width", 1, &[Derivatives]),
    short("cone_spread", 1, &[Derivatives]),
    field("light_u", 1, &[VaryingLights]),
    field("light_v", 1, &[VaryingLights]),
    field("rest", 1, &[SharedCubes]),
    field("survive", 1, &[SharedCubes]),
];

/// Fields of unsigned ints.
const UINTS: &[Field] = &[
    field("sample", 1, &[]),
    field("depth", 1, &[]),
    field("hit_triangle", 1, &[Surfaces]),
    field("hit_instance", 1, &[Instances]),
    field("lobe", 1, &[Surfaces]),
    field("raytype", 1, &[RayType]),
    field("light", 1, &[VaryingLights, EnvironmentSampling]),
    field("turn", 1, &[SplitLobes]),
];

/// A buffer that all stages see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // The names are those of the kernels, which say what each holds.
pub enum BufferId {
    Path,
    PathUint,
    Queues,
    Counters,
    Settings,
    Constants,
    Film,
    Pixels,
    Nodes,
    Triangles,
    TriangleIds,
    Corners,
    Shapes,
    Normals,
    Uvs,
    Areas,
    ObjectSpaces,
    Instances,
    InstanceRoots,
    Lights,
    LightWords,
    EnvironmentCells,
    EnvironmentAlias,
    Messages,
    Textures,
    OtherSpaces,
    Userdata,
    UserdataPlaces,
    Interactive,
    TraceSets,
    TraceNames,
    PointClouds,
}

/// Id, name in the kernels, C type, and which effects call for it (none: always).
type BufferRow = (BufferId, &'static str, &'static str, &'static [Effect]);

const BUFFERS: &[BufferRow] = &[
    (BufferId::Path, "path", "__global real *", &[]),
    (BufferId::PathUint, "path_uint", "__global uint *", &[]),
    (BufferId::Queues, "queues", "__global uint *", &[]),
    (BufferId::Counters, "counters", "volatile __global uint *", &[]),
    (BufferId::Settings, "settings", "__global const uint *", &[]),
    (BufferId::Constants, "constants", "__global const real *", &[]),
    (BufferId::Film, "film", "__global real *", &[]),
    (BufferId::Pixels, "pixels", "__global const uint *", &[Adaptive]),
    (BufferId::Nodes, "nodes", "__global const float4 *", &[Surfaces]),
    (BufferId::Triangles, "triangles", "__global const real4 *", &[Surfaces]),
    (BufferId::TriangleIds, "triangle_ids", "__global const uint *", &[Surfaces]),
    (BufferId::Corners, "corners", "__global const uint *", &[Surfaces]),
    (BufferId::Shapes, "shapes", "__global const uint *", &[Surfaces]),
    (BufferId::Normals, "normals", "__global const float *", &[Normals]),
    (BufferId::Uvs, "uvs", "__global const float *", &[Uvs]),
    (BufferId::Areas, "areas", "__global const real *", &[SurfaceArea]),
    (BufferId::ObjectSpaces, "object_spaces", "__global const real *", &[ObjectSpace]),
    (BufferId::Instances, "instances", "__global const real *", &[Instances]),
    (BufferId::InstanceRoots, "instance_roots", "__global const uint *", &[Instances]),
    (BufferId::Lights, "lights", "__global const real *", &[Lights]),
    (BufferId::LightWords, "light_words", "__global const uint *", &[Lights]),
    (BufferId::EnvironmentCells, "environment_cells", "__global const real *", &[EnvironmentSampling]),
    (BufferId::EnvironmentAlias, "environment_alias", "__global const uint *", &[EnvironmentSampling]),
    (BufferId::Messages, "messages", "__global uint *", &[Messages]),
    (BufferId::Textures, "textures", "__global const uint *", &[Textures]),
    (BufferId::OtherSpaces, "other_spaces", "__global const real *", &[OtherSpaces]),
    (BufferId::Userdata, "userdata", "__global const float *", &[Userdata, Attributes]),
    (BufferId::UserdataPlaces, "userdata_places", "__global const uint *", &[Userdata, Attributes]),
    (BufferId::Interactive, "interactive", "__global const real *", &[Interactive]),
    (BufferId::TraceSets, "trace_sets", "__global const uint *", &[TraceSets]),
    (BufferId::TraceNames, "trace_names", "__global const uint *", &[TraceNames]),
    (BufferId::PointClouds, "clouds", "__global const uint *", &[PointClouds]),
];

/// A setting: an unsigned int that kernels read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Named as in the kernels.
pub enum Setting {
    Width,
    Height,
    Seed,
    MaxDepth,
    RouletteFrom,
    Lights,
    Slots,
    Paths,
    SlotsPerPixel,
    StripeBits,
    PixelFirst,
    SampleFirst,
    SampleEnd,
    Filter,
    TwoSided,
    Split,
}

impl Setting {
    /// All, in the order of the buffer.
    pub const ALL: [(Setting, &'static str); 16] = [
        (Setting::Width, "width"),
        (Setting::Height, "height"),
        (Setting::Seed, "seed"),
        (Setting::MaxDepth, "max_depth"),
        (Setting::RouletteFrom, "roulette_from"),
        (Setting::Lights, "lights"),
        (Setting::Slots, "slots"),
        (Setting::Paths, "paths"),
        (Setting::SlotsPerPixel, "slots_per_pixel"),
        (Setting::StripeBits, "stripe_bits"),
        (Setting::PixelFirst, "pixel_first"),
        (Setting::SampleFirst, "sample_first"),
        (Setting::SampleEnd, "sample_end"),
        (Setting::Filter, "filter"),
        (Setting::TwoSided, "two_sided"),
        (Setting::Split, "split"),
    ];
}

/// A constant of the scene, in reals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Named as in the kernels.
pub enum Constant {
    CameraPosition,
    CameraForward,
    CameraRight,
    CameraUp,
    LensRight,
    LensUp,
    LensRadius,
    FocusDistance,
    Environment,
    CameraSpace,
    EnvironmentShare,
}

impl Constant {
    /// All, in the order of the buffer, with their number of reals.
    pub const ALL: [(Constant, &'static str, u32); 11] = [
        (Constant::CameraPosition, "camera_position", 3),
        (Constant::CameraForward, "camera_forward", 3),
        (Constant::CameraRight, "camera_right", 3),
        (Constant::CameraUp, "camera_up", 3),
        (Constant::LensRight, "lens_right", 3),
        (Constant::LensUp, "lens_up", 3),
        (Constant::LensRadius, "lens_radius", 1),
        (Constant::FocusDistance, "focus_distance", 1),
        (Constant::Environment, "environment", 3),
        (Constant::CameraSpace, "camera_space", 32),
        (Constant::EnvironmentShare, "environment_share", 1),
    ];

    /// Index of its first real.
    pub fn offset(self) -> usize {
        Constant::ALL.iter().take_while(|(c, ..)| *c != self).map(|(.., n)| *n as usize).sum()
    }

    /// Reals of all together.
    pub fn total() -> usize {
        Constant::ALL.iter().map(|(.., n)| *n as usize).sum()
    }
}

/// Counters behind the queues' lengths; 64-bit ones take two words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Named as in the kernels.
pub enum Counter {
    Rays,
    ShadowRays,
    Samples,
    Dropped,
    Repaired,
    Clamped,
    Turns,
}

const COUNTERS: [(Counter, &str, u32); 7] = [
    (Counter::Rays, "rays", 2),
    (Counter::ShadowRays, "shadow_rays", 2),
    (Counter::Samples, "samples", 2),
    (Counter::Dropped, "dropped", 1),
    (Counter::Repaired, "repaired", 1),
    (Counter::Clamped, "clamped", 1),
    (Counter::Turns, "turns", 2),
];

/// Everything's place.
#[derive(Clone, Debug)]
pub struct Layout {
    on: BTreeSet<Effect>,
    queues: Vec<&'static str>,
    materials: u32,
    shaded_lights: u32,
    path_state: PathState,
}

impl Layout {
    /// `materials`: queues of materials. `shaded_lights`: queues of lights whose shader has to be asked.
    pub(super) fn new(on: BTreeSet<Effect>, materials: u32, shaded_lights: u32, path_state: PathState) -> Layout {
        let mut queues = vec!["trace", "done"];
        if DIRECT.iter().any(|e| on.contains(e)) {
            queues.extend(["scatter", "shadow"]);
        }
        if on.contains(&VaryingEnvironment) {
            queues.push("environment");
        }
        if on.contains(&EnvironmentSampling) {
            queues.push("environment_light");
        }
        Layout { on, queues, materials, shaded_lights, path_state }
    }

    fn has(&self, needs: &[Effect]) -> bool {
        needs.is_empty() || needs.iter().any(|e| self.on.contains(e))
    }

    fn is_half(&self, field: &Field) -> bool {
        field.half && self.path_state == PathState::Half
    }

    /// The fields that exist with their places in the records of their kind, and the numbers that records have: of words or reals,
    /// and of halves, which are counted from the first. Triples lie at multiples of four, before the rest.
    fn places(&self, fields: &'static [Field]) -> (Vec<(&'static Field, u32)>, u32, u32) {
        let (mut at, mut half, mut places) = (0, 0, Vec::new());
        let triple = |f: &Field| f.numbers == 3;
        let existing = |first: bool| fields.iter().filter(move |f| self.has(f.needs) && triple(f) == first);
        for field in existing(true).chain(existing(false)) {
            let numbers = if triple(field) { 4 } else { field.numbers };
            match self.is_half(field) {
                true => {
                    places.push((field, FIELD_HALF | half));
                    half += numbers;
                }
                false => {
                    places.push((field, at));
                    at += numbers;
                }
            }
        }
        (places, at, half)
    }

    /// The real of a path's record where halves begin: so that four of them lie as they are read.
    fn halves_first(&self) -> u32 {
        self.places(REALS).1.next_multiple_of(2)
    }

    /// Reals of a path, those that hold halves included: with 32 bits two each. The record behind begins at a multiple of four.
    pub fn reals_per_path(&self) -> u32 {
        let (_, reals, halves) = self.places(REALS);
        let all = if halves > 0 { self.halves_first() + halves.div_ceil(2) } else { reals };
        all.next_multiple_of(4)
    }

    /// Unsigned ints of a path.
    pub fn uints_per_path(&self) -> u32 {
        self.places(UINTS).1
    }

    /// Number of queues.
    pub fn queue_count(&self) -> u32 {
        self.queues.len() as u32 + self.materials + self.shaded_lights
    }

    /// The queue of the k-th light shader.
    pub fn light_queue(&self, k: u32) -> u32 {
        self.queues.len() as u32 + k
    }

    /// The queues of these materials, by their places among those on surfaces.
    pub fn material_queues(&self, materials: Range<u32>) -> Range<u32> {
        let first = self.light_queue(self.shaded_lights);
        first + materials.start..first + materials.end
    }

    /// The queue that `trace` reads, and that later stages of the round fill.
    pub fn trace_queue(&self) -> Range<u32> {
        0..1
    }

    /// Those that are read in the round that fills them.
    pub fn other_queues(&self) -> Range<u32> {
        1..self.light_queue(self.shaded_lights)
    }

    /// Those that may hold paths when a round is over.
    pub fn lasting_queues(&self) -> impl Iterator<Item = u32> {
        self.trace_queue().chain(self.material_queues(0..self.materials))
    }

    /// The queue with this name in the kernels, without `QUEUE_`.
    pub fn queue(&self, name: &str) -> Option<u32> {
        self.queues.iter().position(|q| *q == name).map(|i| i as u32)
    }

    /// Index of a counter in the counters' buffer.
    pub fn counter(&self, counter: Counter) -> usize {
        let before: u32 = COUNTERS.iter().take_while(|(c, ..)| *c != counter).map(|(.., n)| n).sum();
        (self.queue_count() + before) as usize
    }

    /// Words of the counters' buffer.
    pub fn counter_words(&self) -> usize {
        self.queue_count() as usize + COUNTERS.iter().map(|(.., n)| *n as usize).sum::<usize>()
    }

    /// Bytes that a path in flight takes: its records and its places in the queues.
    pub fn bytes_per_path(&self, real_bytes: u64) -> u64 {
        u64::from(self.reals_per_path()) * real_bytes + 4 * u64::from(self.uints_per_path() + self.queue_count())
    }

    /// Bytes of a path that an effect alone adds: its state, before records are filled up, and its places in queues.
    pub fn bytes_of(&self, effect: Effect, real_bytes: u64) -> u64 {
        let bytes = |layout: &Layout| {
            let (_, reals, halves) = layout.places(REALS);
            let words = layout.uints_per_path() + layout.queue_count();
            u64::from(reals) * real_bytes + 2 * u64::from(halves) + 4 * u64::from(words)
        };
        bytes(self).saturating_sub(bytes(&self.without(effect)))
    }

    /// The layout if one effect were off, and all else as it is.
    fn without(&self, effect: Effect) -> Layout {
        let mut on = self.on.clone();
        on.remove(&effect);
        let materials = if effect == Surfaces { 0 } else { self.materials };
        let shaded_lights = if effect == VaryingLights { 0 } else { self.shaded_lights };
        Layout::new(on, materials, shaded_lights, self.path_state)
    }

    /// Names of the buffers that an effect alone adds.
    pub fn buffers_of(&self, effect: Effect) -> Vec<&'static str> {
        let other = self.without(effect);
        self.buffers().filter(|b| !other.buffers().any(|o| o == *b)).map(|(_, name)| name).collect()
    }

    /// Channels of the film.
    pub fn film_channels(&self) -> u32 {
        if self.on.contains(&Holdout) { 4 } else { 3 }
    }

    /// The buffers that exist, in the order of the kernels' arguments.
    pub fn buffers(&self) -> impl Iterator<Item = (BufferId, &'static str)> {
        self.rows().map(|(id, name, ..)| (*id, *name))
    }

    fn rows(&self) -> impl Iterator<Item = &'static BufferRow> {
        BUFFERS.iter().filter(move |(.., needs)| self.has(needs))
    }

    /// The kernels' layout.h.
    pub fn header(&self) -> String {
        let mut out =
            String::from("// Written by the plan of this scene.\n#ifndef OSLCL_LAYOUT_H\n#define OSLCL_LAYOUT_H\n\n");
        let _ = writeln!(out, "#define FILM_CHANNELS {}u", self.film_channels());
        for (prefix, fields) in [("PATH", REALS), ("PATHU", UINTS)] {
            for (field, place) in self.places(fields).0 {
                let _ = writeln!(out, "#define {prefix}_{} {place}u", field.name);
            }
        }
        let _ = writeln!(out, "#define REALS_PER_PATH {}u", self.reals_per_path());
        let _ = writeln!(out, "#define UINTS_PER_PATH {}u", self.uints_per_path());
        if self.places(REALS).2 > 0 {
            let _ = writeln!(out, "#define HALVES_FIRST {}u", self.halves_first());
            let _ = writeln!(out, "#define FIELD_HALF {FIELD_HALF}u");
        }
        for (i, name) in self.queues.iter().enumerate() {
            let _ = writeln!(out, "#define QUEUE_{name} {i}");
        }
        let _ = writeln!(out, "#define QUEUE_MATERIALS {}", self.material_queues(0..0).start);
        let _ = writeln!(out, "#define QUEUE_COUNT {}u", self.queue_count());
        for (counter, name, _) in COUNTERS {
            let _ = writeln!(out, "#define COUNTER_{name} {}u", self.counter(counter));
        }
        for (i, (_, name)) in Setting::ALL.iter().enumerate() {
            let _ = writeln!(out, "#define SETTING_{name} {i}u");
        }
        for (constant, name, _) in Constant::ALL {
            let _ = writeln!(out, "#define CONSTANT_{name} {}u", constant.offset());
        }
        self.arguments(&mut out);
        out.push_str("#endif\n");
        out
    }

    fn arguments(&self, out: &mut String) {
        let list = |f: &dyn Fn(&BufferRow) -> String| self.rows().map(f).collect::<Vec<_>>().join(", ");
        out.push_str("\ntypedef struct {\n");
        for (_, name, ty, _) in self.rows() {
            let _ = writeln!(out, "    {ty}{name};");
        }
        out.push_str("} Context;\n");
        let _ = writeln!(out, "#define STAGE_ARGS {}, uint launch", list(&|(_, name, ty, _)| format!("{ty}{name}")));
        let _ =
            writeln!(out, "#define STAGE_CONTEXT(c) Context c = {{{}}}\n", list(&|(_, name, ..)| (*name).to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers that the header gives to the names with this prefix.
    fn defined(header: &str, prefix: &str) -> Vec<(String, u32)> {
        let lines = header.lines().filter_map(|l| l.strip_prefix("#define ")?.strip_prefix(prefix)?.split_once(' '));
        let number = |n: &str| n.trim_end_matches('u').parse().expect("a number");
        lines.map(|(name, n)| (name.to_owned(), number(n))).collect()
    }

    /// Fields of each kind do not overlap, lie within the record that the host allocates, and triples where they are read at once.
    #[test]
    fn header_and_host_agree_on_path_state() {
        let all: BTreeSet<Effect> = Effect::ALL.iter().copied().collect();
        for on in [BTreeSet::new(), BTreeSet::from([Surfaces, LobeDiffuse, Lights]), all] {
            for path_state in [PathState::Float, PathState::Half] {
                let layout = Layout::new(on.clone(), 3, 2, path_state);
                let header = layout.header();
                for (prefix, fields, total) in
                    [("PATH_", REALS, layout.reals_per_path()), ("PATHU_", UINTS, layout.uints_per_path())]
                {
                    let mut taken = BTreeSet::new();
                    for (name, place) in defined(&header, prefix) {
                        let field = fields.iter().find(|f| f.name == name).expect("a field of the table");
                        let half = place & FIELD_HALF != 0;
                        let triple = field.numbers == 3 && prefix == "PATH_";
                        assert!(!triple || place % 4 == 0, "{name}");
                        for number in 0..if triple { 4 } else { field.numbers } {
                            let at = (place & !FIELD_HALF) + number;
                            // In halves of the record, of which a real has two.
                            let parts =
                                if half { vec![2 * layout.halves_first() + at] } else { vec![2 * at, 2 * at + 1] };
                            for part in parts {
                                assert!(part < 2 * total, "{name}");
                                assert!(taken.insert(part), "{name}");
                            }
                        }
                    }
                }
                let halves = path_state == PathState::Half;
                assert_eq!(header.contains("FIELD_HALF"), halves);
                assert_eq!(layout.reals_per_path() % 4, 0);
            }
        }
    }

    #[test]
    fn header_and_host_agree_on_settings_constants_and_counters() {
        let layout = Layout::new(BTreeSet::from([Surfaces]), 1, 0, PathState::Float);
        let header = layout.header();
        assert_eq!(defined(&header, "SETTING_").len(), Setting::ALL.len());
        for (name, at) in defined(&header, "CONSTANT_") {
            let (constant, ..) = Constant::ALL.into_iter().find(|(_, n, _)| *n == name).expect("a constant");
            assert_eq!(at as usize, constant.offset(), "{name}");
        }
        for (name, at) in defined(&header, "COUNTER_") {
            let (counter, ..) = COUNTERS.into_iter().find(|(_, n, _)| *n == name).expect("a counter");
            assert_eq!(at as usize, layout.counter(counter), "{name}");
        }
        assert!(defined(&header, "COUNTER_").iter().all(|(_, at)| (*at as usize) < layout.counter_words()));
    }

    #[test]
    fn an_effect_that_is_off_adds_no_bytes() {
        let plain = Layout::new(BTreeSet::from([Surfaces, LobeDiffuse]), 1, 0, PathState::Float);
        let lit = Layout::new(BTreeSet::from([Surfaces, LobeDiffuse, Lights]), 1, 0, PathState::Float);
        assert!(lit.bytes_per_path(4) > plain.bytes_per_path(4));
        assert_eq!(plain.bytes_of(Lights, 4), 0);
        let halves = Layout { path_state: PathState::Half, ..lit.clone() };
        assert!(halves.bytes_per_path(4) < lit.bytes_per_path(4));
        // Densities and distances of hits, rays to lights with what they bring: three triples of four reals each, and three reals; and
        // places in the queues of light rays and of paths that wait for them.
        assert_eq!(lit.bytes_of(Lights, 4), 4 * (3 * 4 + 3) + 2 * 4);
    }
}
