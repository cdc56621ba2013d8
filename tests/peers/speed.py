#!/usr/bin/env python3
"""Renders scenes r1 and r2 in oslcl, Mitsuba 3 and Cycles on the same machine, in turns, and writes how many samples a second each takes.

Speed is (N - n) samples a pixel by the difference of the times that N and n of them take: what comes before the first sample (compilers,
trees) does not count. Each mean is held against the converged picture in tests/reference, so that all render the same scene.

- oslcl: the binary on its default device, or the one that --device names.
- Mitsuba 3 (`pip install mitsuba`): scalar_rgb, llvm_ad_rgb (which needs LLVM: name its library by DRJIT_LIBLLVM_PATH), cuda_ad_rgb
  where the machine has it. Path integrator, independent sampler.
- Cycles, as Blender's Python module (`pip install bpy`), on the CPU.
Also needed: numpy, OpenEXR. A renderer that is not installed is left out with a note.

Example:
  tests/peers/speed.py --report docs/reports/speed.md
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib

sys.dont_write_bytecode = True

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
SCENES = {"r1": "R1.exr", "r2": "R2.exr"}
RENDERERS = ["oslcl", "mitsuba scalar_rgb", "mitsuba llvm_ad_rgb", "mitsuba cuda_ad_rgb", "cycles"]
TIMEOUT = 900


def arguments():
    parser = argparse.ArgumentParser(description="Speed of oslcl, Mitsuba 3 and Cycles on the same scenes.")
    parser.add_argument("--in", dest="renderers", nargs="*", choices=RENDERERS, default=RENDERERS, help="renderers")
    parser.add_argument("--scenes", nargs="*", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--spp", type=int, default=64, help="samples a pixel, N (64)")
    parser.add_argument("--least", type=int, default=8, help="samples a pixel, n (8)")
    parser.add_argument("--runs", type=int, default=3, help="runs of each, in turns (3)")
    parser.add_argument("--oslcl", default=os.path.join(ROOT, "target/release/oslcl"), help="our binary")
    parser.add_argument("--device", help="oslcl's device")
    parser.add_argument("--report", help="write the report to this file")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    return parser.parse_args()


def read(name):
    """A scene file, with the reference's path beside it."""
    with open(os.path.join(ROOT, "tests/scenes", name + ".toml"), "rb") as file:
        return tomllib.load(file)


def mesh_path(mesh):
    return os.path.join(ROOT, "tests/scenes", mesh["file"])


class Oslcl:
    def __init__(self, args, name, folder):
        self.command = [args.oslcl, "render", f"tests/scenes/{name}.toml", "-o", os.path.join(folder, "oslcl.exr")]
        self.command += ["--device", args.device] if args.device else []

    def run(self, spp):
        done = subprocess.run(self.command + ["--spp", str(spp)], cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stderr.strip())
        self.title = "oslcl, " + re.search(r"^device +(.*)$", done.stderr, re.M).group(1)
        return float(re.search(r"^render +([0-9.]+) s", done.stderr, re.M).group(1)), self.command[4]


class Mitsuba:
    def __init__(self, args, name, folder, variant):
        import mitsuba as mi

        self.mi, self.path, self.seed = mi, os.path.join(folder, f"{variant}.exr"), 0
        if variant not in mi.variants():
            raise RuntimeError(f"this build has no {variant}")
        mi.set_variant(variant)
        mi.set_log_level(mi.LogLevel.Error)
        self.title = f"Mitsuba {mi.__version__}, {variant}"
        scene = read(name)
        camera, film, integrator = scene["camera"], scene["film"], scene["integrator"]
        parts = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": integrator["max_depth"], "rr_depth": 1 << 20},
            "sensor": {
                "type": "perspective",
                "fov": camera["hfov"],
                "fov_axis": "x",
                "to_world": mi.ScalarTransform4f().look_at(camera["origin"], camera["target"], camera["up"]),
                "film": {"type": "hdrfilm", "width": film["width"], "height": film["height"], "rfilter": {"type": "box"}, "pixel_format": "rgb"},
                "sampler": {"type": "independent"},
            },
        }
        for mesh in scene["meshes"]:
            material = scene["materials"][mesh["material"]]
            shape = {"type": "ply", "filename": mesh_path(mesh), "bsdf": self.bsdf(material)}
            if material["shader"] == "emitter":
                shape["emitter"] = {"type": "area", "radiance": self.rgb(material["params"]["radiance"])}
            parts[mesh["name"]] = shape
        if "environment" in scene:
            parts["sky"] = {"type": "constant", "radiance": self.rgb(scene["environment"]["params"]["radiance"])}
        self.scene = mi.load_dict(parts)
        self.run(1)

    def rgb(self, value):
        return {"type": "rgb", "value": list(value)}

    def bsdf(self, material):
        p = material["params"]
        rough = {"distribution": "ggx", "alpha": p.get("alpha", 0)}
        if material["shader"] == "checker":
            # The floor's texture coordinates go from 0 to 1 over 20 units, and a checkerboard's period is two.
            colors = {"color0": self.rgb(p["color_a"]), "color1": self.rgb(p["color_b"])}
            scale = self.mi.ScalarTransform3f().scale([10, 10])
            inner = {"type": "diffuse", "reflectance": {"type": "checkerboard", "to_uv": scale, **colors}}
        else:
            inner = {
                "matte": lambda: {"type": "diffuse", "reflectance": self.rgb(p["Cs"])},
                "emitter": lambda: {"type": "diffuse", "reflectance": self.rgb([0] * 3)},
                "glass": lambda: {"type": "dielectric", "int_ior": p["ior"], "ext_ior": 1.0},
                "rough_glass_alpha.osl": lambda: {"type": "roughdielectric", "int_ior": p["ior"], "ext_ior": 1.0, **rough},
                "conductor_alpha.osl": lambda: {"type": "roughconductor", "eta": self.rgb(p["eta"]), "k": self.rgb(p["k"]), **rough},
            }[material["shader"]]()
        return inner if "glass" in material["shader"] else {"type": "twosided", "bsdf": inner}

    def run(self, spp):
        self.seed += 1
        start = time.monotonic()
        picture = self.mi.render(self.scene, spp=spp, seed=self.seed)
        self.mi.Bitmap(picture).convert(component_format=self.mi.Struct.Type.Float32).write(self.path)
        return time.monotonic() - start, self.path


class Cycles:
    def __init__(self, args, name, folder):
        import bpy
        import on_cycles

        self.title, self.folder, self.on = on_cycles.version() + ", its own nodes", folder, on_cycles
        scene = read(name)
        camera, film, integrator = scene["camera"], scene["film"], scene["integrator"]
        self.scene = on_cycles.fresh(film["width"], 1, integrator["max_depth"])
        self.scene.cycles.shading_system = False
        made = {}
        for mesh in scene["meshes"]:
            bpy.ops.wm.ply_import(filepath=mesh_path(mesh), forward_axis="Y", up_axis="Z")
            placed = bpy.context.selected_objects[0]
            if mesh["material"] not in made:
                made[mesh["material"]] = self.material(bpy, scene["materials"][mesh["material"]])
            placed.data.materials.clear()
            placed.data.materials.append(made[mesh["material"]])
        world = bpy.data.worlds.new("sky")
        self.scene.world = world
        world.use_nodes = True
        nodes = on_cycles.Nodes(world.node_tree)
        radiance = scene["environment"]["params"]["radiance"] if "environment" in scene else [0, 0, 0]
        background = nodes.add("ShaderNodeBackground", Strength=1.0)
        background.inputs[0].default_value = [*radiance, 1]
        nodes.add("ShaderNodeOutputWorld", Surface=background)
        on_cycles.aim_camera(self.scene, camera["origin"], camera["target"], camera["hfov"], clip_end=1e4)

    def material(self, bpy, material):
        import numpy as np

        p = material["params"]
        out = bpy.data.materials.new("m")
        out.use_nodes = True
        nodes = self.on.Nodes(out.node_tree)

        def colored(kind, color, **more):
            node = nodes.add(kind, **more)
            node.inputs["Color"].default_value = [*color, 1]
            return node

        def glass():
            node = nodes.add("ShaderNodeBsdfGlass", Color=1.0, Roughness=float(np.sqrt(p.get("alpha", 0))), IOR=p["ior"])
            node.distribution = "GGX"
            return node

        def conductor():
            node = nodes.add("ShaderNodeBsdfMetallic", Roughness=float(np.sqrt(p["alpha"])))
            node.fresnel_type, node.distribution = "PHYSICAL_CONDUCTOR", "GGX"
            node.inputs["IOR"].default_value, node.inputs["Extinction"].default_value = p["eta"], p["k"]
            return node

        def math(operation, *values):
            node = nodes.add("ShaderNodeMath", **{f"_{i}": v for i, v in enumerate(values)})
            node.operation = operation
            return node.outputs[0]

        def checker():
            place = nodes.add("ShaderNodeSeparateXYZ", Vector=nodes.add("ShaderNodeNewGeometry").outputs["Position"])
            cells = math("ADD", math("FLOOR", place.outputs[0]), math("FLOOR", place.outputs[1]))
            odd = math("MODULO", math("ABSOLUTE", cells), 2.0)
            even_one, odd_one = (colored("ShaderNodeBsdfDiffuse", p[c]) for c in ("color_a", "color_b"))
            return nodes.add("ShaderNodeMixShader", _0=odd, _1=even_one, _2=odd_one)

        def lamp():
            side = nodes.add("ShaderNodeNewGeometry").outputs["Backfacing"]
            dark = nodes.add("ShaderNodeEmission", Color=0.0, Strength=0.0)
            return nodes.add("ShaderNodeMixShader", _0=side, _1=colored("ShaderNodeEmission", p["radiance"], Strength=1.0), _2=dark)

        surface = {
            "matte": lambda: colored("ShaderNodeBsdfDiffuse", p["Cs"]),
            "emitter": lamp,
            "checker": checker,
            "glass": glass,
            "rough_glass_alpha.osl": glass,
            "conductor_alpha.osl": conductor,
        }[material["shader"]]()
        nodes.add("ShaderNodeOutputMaterial", Surface=surface)
        return out

    def run(self, spp):
        self.scene.cycles.samples = spp
        self.scene.cycles.seed += 1
        start = time.monotonic()
        self.on.shoot(self.scene, self.folder)
        return time.monotonic() - start, os.path.join(self.folder, "cycles.exr")


def make(args, renderer, name, folder):
    kind, _, variant = renderer.partition(" ")
    return {"oslcl": Oslcl, "mitsuba": Mitsuba, "cycles": Cycles}[kind](args, name, folder, *([variant] if variant else []))


def child(args):
    """One renderer, one scene, one run: a line of JSON."""
    from pictures import read_exr

    renderer, name = args.child.split(":")
    with tempfile.TemporaryDirectory() as folder:
        one = make(args, renderer, name, folder)
        least, _ = one.run(args.least)
        most, path = one.run(args.spp)
        picture, reference = read_exr(path), read_exr(os.path.join(ROOT, "tests/reference", SCENES[name]))
        off = [float(picture[..., c].mean() / reference[..., c].mean() - 1) for c in range(3)]
        pixels = picture.shape[0] * picture.shape[1]
    speed = pixels * (args.spp - args.least) / (most - least) / 1e6
    print("RESULT " + json.dumps({"title": one.title, "speed": speed, "off": max(off, key=abs)}), flush=True)


def measure(args, renderer, name):
    """A result, or why there is none."""
    command = [sys.executable, os.path.abspath(__file__), "--child", f"{renderer}:{name}", "--oslcl", args.oslcl]
    command += ["--spp", str(args.spp), "--least", str(args.least)] + (["--device", args.device] if args.device else [])
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return f"not done after {TIMEOUT} s"
    found = re.search(r"^RESULT (.*)$", done.stdout, re.M)
    if found:
        return json.loads(found.group(1))
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    return lines[-1][:160] if lines else f"exit status {done.returncode}"


def main():
    args = arguments()
    if args.child:
        child(args)
        return
    results, notes = {}, []
    for name in args.scenes:
        for _ in range(args.runs):
            for renderer in args.renderers:
                result = measure(args, renderer, name)
                if isinstance(result, str):
                    note = f"{renderer}, {name}: {result}"
                    notes += [note] if note not in notes else []
                    continue
                results.setdefault((name, result["title"]), []).append(result)
                print(f"{name}, {result['title']}: {result['speed']:.2f} Msamples/s, mean {100 * result['off']:+.2f} %", flush=True)
    print("\n".join(notes))
    if args.report:
        write(args, results, notes)


def write(args, results, notes):
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    parts = [
        "# Speed beside other renderers\n\n",
        "Written by `tests/peers/speed.py`; do not edit. Scenes r1 (a Cornell box, depth 8) and r2 (five balls, depth 12), 512 x 512 pixels, on one\n",
        f"machine with {os.cpu_count()} cores, in turns; oslcl of commit {commit}. Medians of {args.runs} runs, with the least and the greatest: millions of samples a\n",
        f"second from {args.least} to {args.spp} samples a pixel, without what comes before the first. *Mean*: the channel that is furthest from the converged\n",
        "picture's.\n",
    ]
    for name in args.scenes:
        parts.append(f"\n## {name}\n\n| renderer | Msamples/s | mean |\n|---|--:|--:|\n")
        rows = [(statistics.median(r["speed"] for r in runs), title, runs) for (n, title), runs in results.items() if n == name]
        for speed, title, runs in sorted(rows, reverse=True):
            least, most = min(r["speed"] for r in runs), max(r["speed"] for r in runs)
            title = f"**{title}**" if title.startswith("oslcl") else title
            parts.append(f"| {title} | {speed:.2f} ({least:.2f} to {most:.2f}) | {100 * runs[-1]['off']:+.2f} % |\n")
    if notes:
        parts.append("\nLeft out: " + "; ".join(notes) + ".\n")
    with open(args.report, "w") as file:
        file.write("".join(parts))


if __name__ == "__main__":
    main()
