"""Scenes of the hard cases in oslcl: a scene file beside PLY files, rendered by the binary.

Rays are shot by trace() of a shader that reads them from two pictures.
"""

import os
import subprocess
import sys

import numpy as np

import meshes
import scenes
from pictures import read_exr, write_exr

BINARY = None  # set by the script
PRECISION = "standard"
NAME = "oslcl"

ALL = '0.4 * diffuse(N) + 0.6 * microfacet("ggx", N, dPdu, 0.05, 0.5, 0, 0)'
LEAKY = {
    "diffuse": "diffuse(N)",
    "mirror": "reflection(N)",
    "metal": 'conductor_bsdf(N, dPdu, 0, 0, color(1), color(1e3), "ggx")',
}


def version():
    """With the commit of this folder, and the device."""
    say = lambda *command: subprocess.run(command, capture_output=True, text=True, cwd=os.path.dirname(__file__)).stdout.strip()
    device = say(BINARY, "devices").partition("\n")[0].partition(": ")[2]
    return f"{say(BINARY, '--version')} (commit {say('git', 'rev-parse', '--short', 'HEAD')}) on {device or 'no device'}"


def number(x):
    return repr(float(x))


def ci(material):
    """The shader's last line."""
    kind, value = material.kind, material.value
    return {
        "diffuse": lambda: f"{number(value)} * diffuse(N)",
        "emitter": lambda: f"{number(value)} * emission()",
        "glow": lambda: f"{number(value)} * emission() + {number(material.albedo)} * diffuse(N)",
        "black": lambda: "0",
        "metal": lambda: '0.9 * microfacet("ggx", N, 0.2, 0, 0)',
        "both": lambda: ALL,
        "glass": lambda: "reflection(N, e) + refraction(N, e)",
        "rough_glass": lambda: f'microfacet("ggx", N, {number(value[0])}, e, 2)',
        "conductor": lambda: "conductor_bsdf(N, dPdu, {2}, {2}, color({0}), color({1}), 'ggx')".format(*map(number, value)).replace(
            "'", '"'
        ),
        "leaky": lambda: f"0.001 * transparent() + 0.999 * {LEAKY[value]}",
    }[kind]()


def source(material):
    if material.kind == "osl":
        return f"surface m() {{ {material.value} }}"
    before = ""
    if material.kind in ("glass", "rough_glass"):
        ior = number(material.value if material.kind == "glass" else material.value[1])
        before = f"float e = backfacing() ? 1 / {ior} : {ior}; "
    return f"surface m() {{ {before}Ci = {ci(material)}; }}"


def triple(v):
    return "[" + ", ".join(number(x) for x in v) + "]"


def matrix(m):
    return "{ matrix = [" + ", ".join(number(x) for x in np.asarray(m).ravel()) + "] }"


def run(folder, text, more=()):
    """Renders the scene's text; the picture's pixels. The binary's error is raised."""
    with open(os.path.join(folder, "scene.toml"), "w") as file:
        file.write(text)
    out = os.path.join(folder, "oslcl.exr")
    command = [BINARY, "render", "scene.toml", "-o", out, "--precision", PRECISION, "--set", "sampler=independent", *more]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(" ".join((done.stderr or done.stdout).split())[:300])
    if "0 values repaired" not in done.stderr + done.stdout:
        print("oslcl repaired values: " + " ".join(done.stderr.split()), file=sys.stderr)
    return read_exr(out)


def head(scene):
    return (
        f"[camera]\norigin = {triple(scene.origin)}\ntarget = {triple(scene.target)}\nhfov = {number(scene.hfov)}\n"
        f"[film]\nwidth = {scene.size}\nheight = {scene.size}\n"
        f"[integrator]\nsamples = {scene.samples}\nmax_depth = {scene.depth}\nroulette = false\nseed = 1\n"
    )


def placed(objects, folder):
    """The tables of meshes and instances. Objects with the same mesh are instances of it."""
    out, names, uses = [], {}, {}
    for o in objects:
        uses[id(o.mesh)] = uses.get(id(o.mesh), 0) + 1
    for k, o in enumerate(objects):
        shared = uses[id(o.mesh)] > 1
        if id(o.mesh) not in names:
            names[id(o.mesh)] = f"mesh{k}"
            meshes.write_ply(o.mesh, os.path.join(folder, f"mesh{k}.ply"))
            out.append(f'[[meshes]]\nname = "mesh{k}"\nfile = "mesh{k}.ply"\nmaterial = "{o.material}"')
            out.append("place = false" if shared else f"transform = {matrix(o.matrix)}")
        if shared:
            name = names[id(o.mesh)]
            out.append(f'[[instances]]\nmesh = "{name}"\nmaterial = "{o.material}"\ntransform = {matrix(o.matrix)}')
    return "\n".join(out) + "\n"


def render(scene, folder):
    names = {}
    materials, objects = [], []
    for o in scene.objects:
        if o.material not in names:
            names[o.material] = f"m{len(names)}"
            materials.append(f"[materials.{names[o.material]}]\nosl = '''\n{source(o.material)}\n'''\n")
        objects.append(scenes.Object(o.mesh, names[o.material], o.matrix))
    before = ""
    if scene.sky is not None:
        before = 'environment = "sky"\n'
        materials.append(f"[materials.sky]\nosl = '''\n{sky(scene.sky, folder)}\n'''\n")
    return run(folder, before + head(scene) + "".join(materials) + placed(objects, folder))


def sky(what, folder):
    """A shader for a sky. A map is looked up in a picture, without a filter."""
    if np.ndim(what) == 0:
        return f"surface s() {{ Ci = {number(what)} * background(); }}"
    write_exr(os.path.join(folder, "sky.exr"), np.repeat(what[..., None], 3, 2))
    return (
        "surface s() { float s = atan2(I[1], I[0]) / M_2PI; s = s < 0 ? s + 1 : s; float t = acos(clamp(I[2], -1, 1)) / M_PI; "
        'color c = texture("sky.exr", s, t, "interp", "closest", "swrap", "periodic", "twrap", "clamp"); Ci = c * background(); }'
    )


PROBE = """surface m(float n = 64)
{
    float x = (floor(u * n) + 0.5) / n, y = (floor((1 - v) * n) + 0.5) / n;
    color o = texture("origins.exr", x, y, "interp", "closest"), d = texture("directions.exr", x, y, "interp", "closest");
    Ci = (1 - trace(point(o), vector(d), "traceset", "target")) * emission();
}"""


def leaks(placement, origins, directions, lengths, folder):
    """How many of these rays miss: n x n of them, one for each pixel of a square that hangs before the camera."""
    n = len(origins)
    write_exr(os.path.join(folder, "origins.exr"), origins)
    write_exr(os.path.join(folder, "directions.exr"), directions)
    eye, unit = placement.camera, placement.unit
    scene = scenes.Scene(eye, eye + np.array([0, -unit, 0]), np.degrees(2 * np.arctan(0.05)), n, 1, 1)
    text = head(scene) + f"[materials.probe]\nosl = '''\n{PROBE}\n'''\nparams = {{ n = {float(n)} }}\n"
    text += "[materials.target]\nosl = 'surface d() { Ci = diffuse(N); }'\nattributes = { traceset = \"target\" }\n"
    # Seen along -y its left is at +x: turned round, u runs to the right again.
    square = scenes.affine(scenes.HALF_TURN * 0.05 * unit, eye + np.array([0, -unit, 0]))
    objects = [scenes.Object(meshes.wall(), "probe", square)]
    objects += [scenes.Object(placement.mesh, "target", m) for m in placement.matrices()]
    picture = run(folder, text + placed(objects, folder))
    return int((picture[..., 0] > 0.5).sum()), lengths.size
