"""Scenes, rays and BSDFs of the hard cases in Mitsuba 3.

Pictures come from a scalar variant; rays and BSDFs, which are many at a time, from an LLVM one. Both trace rays with Embree.
"""

import os

import mitsuba as mi
import numpy as np

import meshes
from pictures import write_exr

PICTURES, ARRAYS = "scalar_rgb", "llvm_ad_rgb"
NAME = "Mitsuba 3"
ROBUST = False  # Embree's robust mode; Mitsuba's default is off
mi.set_log_level(mi.LogLevel.Error)

GOLD = {"eta": {"type": "rgb", "value": [0.143, 0.375, 1.442]}, "k": {"type": "rgb", "value": [3.983, 2.386, 1.603]}}


def version():
    return f"Mitsuba {mi.__version__}"


def two_sided(bsdf):
    return {"type": "twosided", "bsdf": bsdf}


def gray(x):
    return {"type": "rgb", "value": [float(x)] * 3}


def diffuse(albedo):
    return two_sided({"type": "diffuse", "reflectance": gray(albedo)})


def leaky(of):
    inner = {
        "diffuse": {"type": "diffuse", "reflectance": gray(1)},
        "mirror": {"type": "conductor", "material": "none"},
        "metal": conductor(1.0, 1000.0, 0),
    }[of]
    return {"type": "mask", "opacity": 0.999, "bsdf": two_sided(inner)}


def rough_glass(alpha, ior):
    if alpha == 0:
        return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    return {"type": "roughdielectric", "alpha": alpha, "int_ior": ior, "ext_ior": 1.0, "distribution": "ggx"}


def conductor(n, k, alpha):
    ior = {"eta": {"type": "uniform", "value": n}, "k": {"type": "uniform", "value": k}}
    if alpha == 0:
        return {"type": "conductor", **ior}
    return {"type": "roughconductor", "alpha": alpha, "distribution": "ggx", **ior}


def bsdf(material):
    kind, value = material.kind, material.value
    mirror = {"type": "roughconductor", "material": "none", "distribution": "ggx"}
    if kind == "both":
        parts = {"a": {"type": "diffuse", "reflectance": gray(1)}, "b": mirror | {"alpha_u": 0.05, "alpha_v": 0.5}}
        return two_sided({"type": "blendbsdf", "weight": 0.6, **parts})
    return {
        "diffuse": lambda: diffuse(value),
        "emitter": lambda: diffuse(0),
        "glow": lambda: diffuse(material.albedo),
        "black": lambda: diffuse(0),
        "metal": lambda: two_sided(mirror | {"alpha": 0.2, "specular_reflectance": 0.9}),
        "glass": lambda: {"type": "dielectric", "int_ior": value, "ext_ior": 1.0},
        "rough_glass": lambda: rough_glass(*value),
        "conductor": lambda: two_sided(conductor(*value)),
        "leaky": lambda: leaky(value),
    }[kind]()


def transform(m):
    return mi.ScalarTransform4f(np.asarray(m, float))


def shapes(objects, folder):
    """Objects with the same mesh are instances of a group."""
    uses = {}
    for o in objects:
        uses.setdefault(id(o.mesh), []).append(o)
    out = {}
    for k, copies in enumerate(uses.values()):
        path = os.path.join(folder, f"mesh{k}.ply")
        meshes.write_ply(copies[0].mesh, path)
        flat = copies[0].mesh.normals is None
        for j, o in enumerate(copies):
            shape = {"type": "ply", "filename": path, "face_normals": flat, "bsdf": bsdf(o.material)}
            if o.material.kind in ("emitter", "glow"):
                shape["emitter"] = {"type": "area", "radiance": gray(o.material.value)}
            if len(copies) == 1:
                out[f"shape{k}"] = shape | {"to_world": transform(o.matrix)}
                continue
            # A BSDF belongs to the group's shape: copies with other materials need a group of their own.
            group = f"group{k}_{[c.material for c in copies].index(o.material)}"
            if group not in out:
                out[group] = {"type": "shapegroup", "shape": shape}
            out[f"instance{k}_{j}"] = {"type": "instance", "group": {"type": "ref", "id": group}, "to_world": transform(o.matrix)}
    return out


def sky(what, folder):
    if np.ndim(what) == 0:
        return {"type": "constant", "radiance": gray(what)}
    # Its columns run the other way round.
    path = os.path.join(folder, "sky_mitsuba.exr")
    write_exr(path, np.repeat(what[:, ::-1, None], 3, 2))
    up = [[0, 0, -1, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]
    return {"type": "envmap", "filename": path, "to_world": transform(up)}


def load(parts):
    return mi.load_dict({"type": "scene", "embree_use_robust_intersections": ROBUST, **parts})


def render(scene, folder):
    """Defaults, but: no Russian roulette, a box filter of one pixel, clipping planes that scale with the scene."""
    if any(o.material.kind == "osl" for o in scene.objects):
        raise NotImplementedError("no OSL")
    mi.set_variant(PICTURES)
    distance = np.linalg.norm(scene.target - scene.origin)
    film = {"type": "hdrfilm", "width": scene.size, "height": scene.size, "rfilter": {"type": "box"}}
    film |= {"pixel_format": "rgb", "component_format": "float32"}
    camera = {
        "type": "perspective",
        "fov": scene.hfov,
        "fov_axis": "x",
        "near_clip": float(distance * 1e-2),
        "far_clip": float(distance * 1e4),
        "to_world": mi.ScalarTransform4f().look_at(scene.origin.tolist(), scene.target.tolist(), [0, 0, 1]),
        "film": film,
        "sampler": {"type": "independent", "sample_count": scene.samples, "seed": 1},
    }
    parts = {"sensor": camera, "integrator": {"type": "path", "max_depth": scene.depth, "rr_depth": 1 << 20}}
    if scene.sky is not None:
        parts["sky"] = sky(scene.sky, folder)
    return np.array(mi.render(load(parts | shapes(scene.objects, folder))))


def target(placement, folder):
    import scenes

    objects = [scenes.Object(placement.mesh, scenes.WHITE, m) for m in placement.matrices()]
    return load(shapes(objects, folder))


def leaks(placement, origins, directions, lengths, folder):
    """How many of these rays miss."""
    mi.set_variant(ARRAYS)
    scene = target(placement, folder)
    o, d = origins.reshape(-1, 3), directions.reshape(-1, 3)
    ray = mi.Ray3f(mi.Point3f(o.T), mi.Vector3f(d.T))
    return int((~np.array(scene.ray_intersect_preliminary(ray).is_valid())).sum()), len(o)


def leaves(placement, origins, directions, seed, folder):
    """Rays off the surface as spawn_ray sends them, from where these rays meet it: share of them that meet the surface again, of rays
    into it that miss, and points without a sound state. Cosines evenly in the logarithm, down to 1e-6."""
    mi.set_variant(ARRAYS)
    scene = target(placement, folder)
    si = scene.ray_intersect(mi.Ray3f(mi.Point3f(origins.T), mi.Vector3f(directions.T)))
    valid = np.array(si.is_valid())
    if valid.mean() < 0.5:
        raise NotImplementedError(f"{valid.sum()} of {valid.size} rays meet it")
    middle = placement.matrix[:3, 3]
    draw = np.random.default_rng(seed).random
    n, p = np.array(si.n).T.astype(float), np.array(si.p).T.astype(float)
    state = np.isfinite(np.array(si.sh_frame.n).T).all(1) & np.isfinite(np.array(si.dp_du).T).all(1) & np.isfinite(p).all(1)
    sound = state & (np.abs((n * n).sum(1) - 1) < 1e-4)
    good = valid & sound
    n = np.where(good[:, None], n, [0, 0, 1])
    n *= np.where((n * (p - middle)).sum(1, keepdims=True) < 0, -1, 1)
    s = np.cross(n, np.where(np.abs(n[:, :1]) > 0.5, [0, 1, 0], [1, 0, 0]))
    s /= np.linalg.norm(s, axis=1, keepdims=True)
    z, turn = np.exp(np.log(1e-6) * draw((len(n), 1))), 2 * np.pi * draw((len(n), 1))
    side = np.sqrt((1 - z) * (1 + z)) * (s * np.cos(turn) + np.cross(n, s) * np.sin(turn))
    shoot = lambda d: scene.ray_intersect_preliminary(si.spawn_ray(mi.Vector3f(d.astype(np.float32).T)))
    out, into = shoot(side + n * z), shoot(side - n * z)
    far = 100 * np.linalg.norm(p - middle, axis=1)
    met = np.array(out.is_valid()) & (np.array(out.t) < far)
    share = lambda x: float((x & good).sum()) / max(1, good.sum())
    return {
        "rays off the surface that meet it": int((met & good).sum()),
        "share of rays into it that fall through": share(~np.array(into.is_valid())),
        "points without a sound state": int((valid & ~sound).sum()),
    }
