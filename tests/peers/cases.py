"""The hard cases: what is rendered or shot, what is measured, and the bound that our own tests hold it to.

In: a renderer's module (on_*.py). Out: a number of each case, or why there is none. Names and measures are those of
tests/tests/hard_cases_*.rs, so that rows can be matched with docs/reports/stability.md. It must not know how anything is rendered.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Callable

import numpy as np

import meshes
import rays
import scenes
from scenes import Material

SIDE = 256  # rays of a placement: SIDE x SIDE
SAMPLES_OF_BSDFS = 1 << 12
ALL = ("oslcl", "mitsuba", "robust", "cycles")


@dataclass
class Case:
    """`measure(renderer, folder)` gives a number, a number and its noise, or a text."""

    group: str
    name: str
    bound: float
    measure: Callable
    own: str | None = None  # the row of docs/reports/stability.md, unless it has the same name
    only: tuple = ALL
    why: str = ""  # what the others lack


def picture(group, name, bound, scene, measure, own=None, noise=None):
    """A picture and a number of it. A number on the film that is infinite, none or negative counts for more than the measure.
    `noise`: gives what chance may add to the number, from renderer, folder and pixels."""

    def run(renderer, folder):
        pixels = renderer.render(scene(), folder).astype(float)
        broken = film(pixels)
        if broken:
            return broken
        if measure is brightest and not pixels.any():
            return "0 (black)"
        if noise is None:
            return float(measure(pixels))
        return [float(measure(pixels)), float(noise(renderer, folder, pixels))]

    return Case(group, name, bound, run, own)


def film(pixels):
    """What is wrong with the numbers on a film, or nothing."""
    lost, negative = int((~np.isfinite(pixels)).sum()), int((pixels < 0).sum())
    said = []
    if lost:
        said.append(f"{lost} of {pixels.size} numbers on the film not finite")
    if negative:
        said.append(f"{negative} of {pixels.size} numbers on the film negative, to {np.nanmin(pixels):.1e}")
    return ", ".join(said)


def mean(pixels):
    return pixels[..., 0].mean()


def brightest(pixels):
    """The brightest number."""
    return pixels.max()


def off(expected):
    """How far a picture's mean is from what it should be, as a part."""
    return lambda pixels: abs(mean(pixels) / expected - 1)


def far_from(expected):
    return lambda pixels: abs(mean(pixels) - expected)


def error(group, name, bound, scene, expected, own=None, relative=True):
    """The error of the mean of a picture that is of one colour: its pixels' scatter is noise, of which 4.5 sigma are not held against it."""
    measure = off(expected) if relative else far_from(expected)
    scatter = (
        lambda renderer, folder, pixels: 4.5 * pixels[..., 0].std() / np.sqrt(pixels[..., 0].size) / (expected if relative else 1)
    )
    return picture(group, name, bound, scene, measure, own, scatter)


def geometry():
    out = []
    for k, p in enumerate(rays.placements()):

        def leaks(renderer, folder, p=p, seed=1 + k, shoot=rays.aimed):
            o, d, lengths = shoot(p, SIDE * SIDE, seed)
            square = lambda x: x.reshape(SIDE, SIDE, *x.shape[1:])
            missed, of = renderer.leaks(p, square(o), square(d), square(lengths), folder)
            return missed if of == SIDE * SIDE else f"{missed} of {of} (shorter rays are cut off by its cameras)"

        out.append(Case("geometry", f"{p.name}: leaks through edges and vertices", 0.0, leaks))
        if "needles" in p.name:
            continue
        if "scales" not in p.name:
            along = lambda renderer, folder, leaks=leaks, seed=101 + k: leaks(renderer, folder, seed=seed, shoot=rays.axial)
            out.append(Case("geometry", f"{p.name}: leaks along the axes", 0.0, along))

        def leaves(renderer, folder, p=p, seed=201 + k):
            o, d, _ = rays.aimed(p, SIDE * SIDE, seed, inside=True)
            return renderer.leaves(p, o, d, seed, folder)

        only, why = ("mitsuba", "robust"), "no such function; see the white ball"
        bounds = {
            "rays off the surface that meet it": 0.0,
            "share of rays into it that fall through": p.thin,
            "points without a sound state": 0.0,
        }
        for what, bound in bounds.items():
            one = lambda renderer, folder, leaves=leaves, what=what: leaves(renderer, folder)[what]
            out.append(Case("geometry", f"{p.name}: {what}", bound, one, None, only, why))
        if "1e7" in p.name:
            continue  # a renderer that has lost the ball shows the same picture
        name = f"{p.name}, white, under a white sky: error of the mean"
        out.append(error("geometry", name, 1e-5, lambda p=p: white(p), 1.0))
    return out


def white(p):
    """A white convex mesh under a white sky is not seen, unless a ray meets the surface that it left."""
    size = np.linalg.norm(p.matrix[:3, 1])
    hfov = np.degrees(2 * np.arctan(0.88 * size / np.linalg.norm(p.camera - p.matrix[:3, 3])))
    scene = scenes.Scene(p.camera, p.matrix[:3, 3], hfov, depth=2, sky=1.0)
    for m in p.matrices():
        scene.put(p.mesh, scenes.WHITE, m)
    return scene


def whole_scenes():
    out = []
    far = (1e7, -2e7, 3e7)

    @lru_cache
    def base(renderer, folder):
        return renderer.render(scenes.corner(), folder).astype(float)

    for name, scale, shift in [
        ("scaled by 1e-6", 1e-6, (0, 0, 0)),
        ("scaled by 1e6", 1e6, (0, 0, 0)),
        ("moved 1e7 units away", 1.0, far),
        ("scaled by 1e6 and moved 1e7 units away", 1e6, far),
    ]:

        def difference(renderer, folder, scale=scale, shift=shift):
            first = base(renderer, folder)
            pixels = renderer.render(scenes.corner(scale, shift), folder).astype(float)
            return float(np.abs(pixels[..., 0] - first[..., 0]).mean() / mean(first))

        out.append(Case("scenes", f"corner {name}: difference of the picture, as a part", 5e-3, difference))
    plain = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    front, both = [[0, -1, 0]] * 4, Material("both")

    @lru_cache
    def scatter(renderer, folder):
        return renderer.render(scenes.furnace(meshes.wall(front, plain), both), folder).astype(float)[..., 0].std()

    # Pixels' scatter without anything that is hard.
    usual = lambda renderer, folder, pixels: 4.5 * scatter(renderer, folder)
    for name, normals, uvs in [
        ("all uv the same", front, [[0.5, 0.5]] * 4),
        ("uv along a line", front, [[0, 0], [1, 1], [2, 2], [3, 3]]),
        ("uv 1e-20 apart", front, plain * 1e-20),
        ("uv 1e20 apart", front, plain * 1e20),
        ("normals of length 0", [[0, 0, 0]] * 4, plain),
        ("normals flipped", [[0, 1, 0]] * 4, plain),
        ("normals that cancel", [[1, 0, 0], [-1, 0, 0], [1, 0, 0], [-1, 0, 0]], plain),
        ("normals below the horizon", [[1, -0.001, 0], [0, -0.001, 1], [-1, 0.001, 0], [0, 0.001, -1]], plain),
        ("normals of length 1e-30", [[0, -1e-30, 0]] * 4, plain),
    ]:
        scene = lambda normals=normals, uvs=uvs: scenes.furnace(meshes.wall(normals, uvs), both)
        out.append(picture("scenes", f"{name}: brightest pixel in a white room", 1 + 1e-5, scene, brightest, None, usual))
    glow = Material("glow", 0.25, 0.5)
    name = "triangles without area that glow: error of the mean"
    out.append(error("scenes", name, 1e-5, lambda: scenes.furnace(meshes.dust(), glow), 0.75, relative=False))

    def again(mesh, material, copies, **more):
        scene = scenes.furnace(mesh(), material, **more)
        for _ in range(copies):
            scene.put(mesh(), material)
        return scene

    name = "four walls in one place: error of the mean"
    out.append(error("scenes", name, 1e-5, lambda: again(meshes.wall, scenes.HALF, 3), 0.5, relative=False))
    ball, glass = lambda: meshes.ball(24, 12), Material("glass", 1.5)
    name = "glass in glass in one place: error of the mean"
    out.append(error("scenes", name, 2e-3, lambda: again(ball, glass, 1, depth=200), 1.0, relative=False))
    for name, size, at in [("room", 1.0, 0.0), ("room of 1e-6", 1e-6, 0.0), ("room of 1e6, 1e7 away", 1e6, 1e7)]:
        name += ", a sky of 1e9 around it: mean inside"
        out.append(picture("scenes", name, 0.0, lambda size=size, at=at: scenes.room(meshes.cube(6), size, at), mean))
    own = "cover 1e-4 units (f64: 1e-9) from a lamp, 8 from the wall: light that passes"
    out.append(
        picture(
            "scenes", "cover 1e-4 units from a lamp, 8 from the wall: light that passes", 0.0, lambda: scenes.cover(1e-4), mean, own
        )
    )
    return out


def lights():
    out = []

    def lit(name, bound, scene, expected):
        out.append(error("lights", f"{name}: error of the mean", bound, scene, expected))

    for name, radiance, size, h, bound in [
        ("lamp 1e-6 across", 1e12, 5e-7, 8.0, 1e-5),
        ("lamp 1e-6 across, 1e-6 away", 1.0, 5e-7, 1e-6, 0.1),
        ("lamp of 1e-12", 1e-12, 1.0, 8.0, 2e-3),
        ("lamp of 1e12", 1e12, 1.0, 8.0, 2e-3),
        ("lamp a million times wider than its distance", 1.0, 1e3, 1e-3, 0.02),
    ]:
        lit(name, bound, lambda r=radiance, s=size, h=h: scenes.lamp(r, s, h, 64), scenes.under_square(radiance, size, h))
    many = lambda: scenes.hang(scenes.spot(), meshes.grid(224), 3.0, 1.0, 8.0)
    lit("100,352 lamps", 2e-3, many, scenes.under_square(3.0, 1.0, 8.0))

    def faint():
        scene = scenes.spot(samples=256, origin=np.array([0.0, -0.25, 0.0]))
        scenes.hang(scene, meshes.wall(), 1e-12, 2.0, 0.5)
        return scenes.hang(scene, meshes.wall(), 1e12, 1.0, 20.0, np.eye(3))

    lit("1e-12 beside 1e12", 0.02, faint, scenes.under_square(1e-12, 2.0, 0.5))
    for name, size in [("lamp all around", 10.0), ("lamp that touches", 1.0), ("lamp that cuts", 0.7)]:
        lit(name, 5e-3, lambda size=size: scenes.shining_room(meshes.cube(2, True, size), 256), 0.5)
    pixel = scenes.pixel_of([0.3, -0.8, 0.4])
    form = scenes.light_of(pixel)
    behind = [(row, column) for row in (127, 128) for column in (127, 128)]
    lit(
        "sky of 1 with one pixel of 1e9",
        5e-3,
        lambda: scenes.under_sky(scenes.sky_map(1, 1e9, [pixel]), 256),
        0.5 * (1e9 * form / np.pi + 1),
    )
    lit(
        "black sky with one pixel of 1e9",
        5e-3,
        lambda: scenes.under_sky(scenes.sky_map(0, 1e9, [pixel]), 256),
        0.5 * 1e9 * form / np.pi,
    )
    lit("sky of 1 with 1e9 behind the wall", 0.02, lambda: scenes.under_sky(scenes.sky_map(1, 1e9, behind), 256), 0.5)
    out.append(picture("lights", "black sky: mean", 0.0, lambda: scenes.under_sky(scenes.sky_map(0), 256), mean))
    return out


def lobes():
    out = []
    ball = lambda: meshes.ball(24, 12)
    expected = 1 - 0.999**999
    noise = 4.5 * np.sqrt(expected * (1 - expected) / 1024)
    inside = lambda of: lambda: scenes.inside_ball(ball(), of, 4)
    out.append(
        picture("bsdf", "white diffuse ball to depth 1,000: error of the mean", noise, inside("diffuse"), far_from(expected))
    )
    for name, of in (("mirror", "mirror"), ("metal of k = 1e3", "metal")):
        out.append(picture("bsdf", f"{name} to depth 1,000: mean", expected + noise + 1e-5, inside(of), mean))

    out += single_lobes()

    def white_room(name, material, kept):
        # A rough lobe loses light, as it scatters once; metals absorb some. Light that is made is an error in all.
        scene = lambda: scenes.furnace(meshes.sphere(), material, depth=100)
        if kept:
            out.append(error("bsdf, white room", f"{name}: error of the mean", 2e-3, scene, 1.0))
        else:
            scatter = lambda renderer, folder, pixels: 4.5 * pixels[..., 0].std() / np.sqrt(pixels[..., 0].size)
            out.append(picture("bsdf, white room", f"{name}: mean", 1 + 1e-5, scene, mean, None, scatter))

    for alpha in (0.0, 1e-7, 1e-4, 1e-2, 0.1, 1.0):
        white_room(f"ball of glass, roughness {alpha:g}", Material("rough_glass", (alpha, 1.5)), alpha <= 1e-4)
    for ior, text in ((1 - 1e-7, "1 - 1e-7"), (1 + 1e-7, "1 + 1e-7"), (1e-3, "1e-3"), (1e3, "1e3")):
        for alpha in (0.0, 0.1):
            white_room(
                f"ball of glass, ior {text}, roughness {alpha:g}",
                Material("rough_glass", (alpha, ior)),
                alpha == 0 and 0.1 < ior < 10,
            )
    for n, k in ((1e-3, 0.0), (1e-3, 1e3), (1.0, 0.0), (1.0, 1e3), (1e3, 0.0), (1e3, 1e3)):
        for alpha in (0.0, 0.1):
            white_room(
                f"ball of metal, n {n:g}, k {k:g}, roughness {alpha:g}",
                Material("conductor", (n, k, alpha)),
                alpha == 0 and n <= 1 < k,
            )
    return out


def single_lobes():
    names = ["roughness 0, 1e-7 .. 1", "roughness 1e-4 : 1", "cosines to 1e-8", "cosines to 1e-8, mirrors", "ior 1 +- 1e-7"]
    names += ["the edge of total reflection", "ior 1e-3 and 1e3", "conductors, n 1e-3 .. 1e3, k 0 .. 1e3"]
    sharp = {"roughness 0, 1e-7 .. 1", "roughness 1e-4 : 1", "conductors, n 1e-3 .. 1e3, k 0 .. 1e3"}
    measures = {"broken": 0.0, "energy": 1 + 1e-5, "pdf": None, "value": None, "reciprocity": None}
    out = []

    @lru_cache
    def measured(family):
        import bsdfs

        return bsdfs.measure(family, SAMPLES_OF_BSDFS)

    for family in names:
        for short, bound in measures.items():

            def one(renderer, folder, family=family, short=short):
                import bsdfs

                worst, refused, where = measured(family)
                number = float(worst[short])
                if refused and short == "broken":
                    return f"{number:g}; {len(refused)} BSDFs refused: {refused[0].split('] ')[-1]}"
                return number

            what = MEASURES[short]
            bound = (0.06 if family in sharp else 0.01) if bound is None else bound
            out.append(Case("bsdf", f"{family}: {what}", bound, one, None, ("mitsuba",), "no such function"))
    return out


MEASURES = {
    "broken": "samples with a number that is not finite, or negative",
    "energy": "light scattered, less 4.5 sigma",
    "pdf": "share of samples whose density is 5 % off that of evaluation",
    "value": "share of samples whose value is 5 % off f / pdf",
    "reciprocity": "share of samples 5 % off reciprocity",
}


def numbers():
    out = []
    for power in (20, 24):
        scene = lambda power=power: scenes.Scene(size=1, samples=1 << power, sky=0.1)
        name = f"one pixel of 2^{power} samples of a sky of 0.1: error of the mean, as a part"
        out.append(picture("accumulation", name, 1e-5, scene, off(float(np.float32(0.1)))))

    def random(which):
        def run(renderer, folder):
            import bsdfs

            return bsdfs.random_numbers(1 << 24)[which]

        return run

    why = "no such function"
    for name, which, bound, own in [
        ("2^24 random numbers: outside [0, 1)", 0, 0.0, "all 2^24 values of a random number: outside [0, 1)"),
        (
            "2^24 random numbers: distance of the mean from 1/2",
            1,
            5 / np.sqrt(12 * 2.0**24) + 1e-6,
            "counters from 0 on: distance of the mean from 1/2",
        ),
    ]:
        out.append(Case("random", name, bound, random(which), own, ("mitsuba",), why))
    return out


def shaders():
    out = []
    for name, text, expected, bound in [
        ("division by zero", "float z = P[1] * 0; Ci = (1 + 1 / z + z / z + 0 / z) * emission();", 1.0, 1e-6),
        (
            "roots and logarithms of negative numbers",
            "float z = P[1] * 0 - 1; Ci = (1 + sqrt(z) + inversesqrt(z) + 0 * log(z) + pow(z, 0.5)) * emission();",
            1.0,
            1e-6,
        ),
        (
            "vectors of length 0",
            "vector z = vector(P[1] * 0); Ci = (1 + length(normalize(z)) + dot(normalize(z), N)) * emission();",
            1.0,
            1e-6,
        ),
        ("a loop of 1e6 turns", "float s = 0; for (int i = 0; i < 1000000; i++) s += 1; Ci = s * 1e-6 * emission();", 1.0, 1e-6),
        ("denormals, flushed or not", "float z = P[1] * 0 + 1e-40; Ci = (1 + z + z * 1e30 + sqrt(z) * 0) * emission();", 1.0, 1e-6),
        ("perlin noise at 1e9", 'Ci = (0.5 + 0.25 * noise("perlin", P * 1e9)) * emission();', 0.5, 0.25),
        ("simplex noise at 1e9", 'Ci = (0.5 + 0.25 * noise("simplex", P * 1e9)) * emission();', 0.5, 0.25),
        ("cell noise at 1e9", 'Ci = noise("cell", P * 1e9) * emission();', 0.5, 0.5),
        ("periodic noise at 1e9", 'Ci = pnoise("uperlin", P * 1e9, point(1e9)) * emission();', 0.5, 0.5),
        ("gabor noise at 1e9", 'Ci = (0.5 + 0.25 * noise("gabor", P * 1e9)) * emission();', 0.5, 0.5),
    ]:
        name = f"{name}: distance of the mean from {expected:g}"
        out.append(picture("shaders", name, bound, lambda text=text: scenes.glowing(text), far_from(expected)))
    return out


def all_cases():
    return geometry() + whole_scenes() + lights() + lobes() + numbers() + shaders()
