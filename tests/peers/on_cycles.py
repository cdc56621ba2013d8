"""Scenes and rays of the hard cases in Cycles, by Blender as a Python module (bpy).

Rays are shot by a camera of its own (an OSL shader) that reads them from two pictures: what it sees white has missed.
"""

import os

import bpy
import mathutils
import numpy as np

import scenes
from pictures import read_exr, write_exr

NAME = "Cycles"
NEAREST = 1e-6  # Blender's cameras cut off what is nearer


def version():
    return f"Cycles of Blender {bpy.app.version_string}"


def fresh(size, samples, depth):
    """An empty scene. Defaults, but: no adaptive sampling, denoising, clamping, blur of glossy light or threshold of lights, which trade
    light for noise on purpose; no Russian roulette; a box filter of one pixel; bounces as asked for."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.shading_system = True
    cycles.samples, cycles.seed = samples, 1
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    # Cycles counts bounces after the first hit: d edges are d - 2 of them.
    bounces = max(0, depth - 2)
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces = max(8, depth)
    cycles.min_light_bounces = cycles.min_transparent_bounces = 1024
    render = scene.render
    render.resolution_x = render.resolution_y = size
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "AUTO", 0
    picture = render.image_settings
    picture.file_format, picture.color_depth, picture.color_mode, picture.exr_codec = "OPEN_EXR", "32", "RGB", "NONE"
    scene.view_settings.view_transform = "Raw"
    return scene


class Nodes:
    """A tree of shader nodes, emptied."""

    def __init__(self, tree):
        self.tree = tree
        tree.nodes.clear()

    def add(self, kind, **inputs):
        node = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            self.put(node, name, value)
        return node

    def put(self, node, name, value):
        socket = node.inputs[int(name[1:])] if name[0] == "_" and name[1:].isdigit() else node.inputs[name.replace("_", " ")]
        if isinstance(value, bpy.types.Node):
            self.tree.links.new(value.outputs[0], socket)
        elif isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = [value] * 3 + [1] if socket.type == "RGBA" else value


def surface(nodes, material, folder):
    """The node whose output goes to the surface."""
    kind, value = material.kind, material.value
    add = nodes.add

    def glossy(alpha, color, **more):
        node = add("ShaderNodeBsdfAnisotropic", Color=color, Roughness=float(np.sqrt(alpha)), **more)
        node.distribution = "GGX"
        return node

    def front(radiance):
        # Lamps shine on their front side.
        lamp = add("ShaderNodeEmission", Color=1.0, Strength=float(radiance))
        side = add("ShaderNodeNewGeometry").outputs["Backfacing"]
        return add("ShaderNodeMixShader", _0=side, _1=lamp, _2=add("ShaderNodeEmission", Color=0.0, Strength=0.0))

    def both():
        # Cycles has one roughness r and an anisotropy a: alphas are r^2 / (1 - a) and r^2 (1 - a), here 0.05 and 0.5.
        a = 1 - np.sqrt(0.1)
        tangent = add("ShaderNodeTangent")
        tangent.direction_type, tangent.uv_map = "UV_MAP", "uv"
        shine = glossy(0.05 / (1 - a), 1.0, Anisotropy=float(a), Tangent=tangent, Rotation=0.25)
        return add("ShaderNodeMixShader", _0=0.6, _1=add("ShaderNodeBsdfDiffuse", Color=1.0), _2=shine)

    def leaky():
        inner = {
            "diffuse": lambda: add("ShaderNodeBsdfDiffuse", Color=1.0),
            "mirror": lambda: add("ShaderNodeBsdfAnisotropic", Color=1.0, Roughness=0.0),
            "metal": metal,
        }[value]()
        return add("ShaderNodeMixShader", _0=0.999, _1=add("ShaderNodeBsdfTransparent", Color=1.0), _2=inner)

    def metal(n=1.0, k=1e3, alpha=0.0):
        node = add("ShaderNodeBsdfMetallic", Roughness=float(np.sqrt(alpha)))
        node.fresnel_type = "PHYSICAL_CONDUCTOR"
        node.inputs["IOR"].default_value = [n] * 3
        node.inputs["Extinction"].default_value = [k] * 3
        return node

    def script():
        path = os.path.join(folder, f"material{len(os.listdir(folder))}.osl")
        with open(path, "w") as file:
            file.write("#define Ci Out\nshader material(output closure color Out = 0)\n{\n    " + value + "\n}\n")
        node = add("ShaderNodeScript")
        node.mode, node.filepath = "EXTERNAL", path
        # The module lacks oslquery, by which Blender finds a script's outputs; Cycles compiles it all the same.
        if not node.outputs:
            node.outputs.new("NodeSocketShader", "Out")
        return node

    return {
        "diffuse": lambda: add("ShaderNodeBsdfDiffuse", Color=float(value)),
        "emitter": lambda: front(value),
        "glow": lambda: add("ShaderNodeAddShader", _0=front(value), _1=add("ShaderNodeBsdfDiffuse", Color=material.albedo)),
        "black": lambda: add("ShaderNodeBsdfDiffuse", Color=0.0),
        "metal": lambda: glossy(0.2, 0.9),
        "both": both,
        "glass": lambda: add("ShaderNodeBsdfGlass", Color=1.0, Roughness=0.0, IOR=float(value)),
        "rough_glass": lambda: add("ShaderNodeBsdfGlass", Color=1.0, Roughness=float(np.sqrt(value[0])), IOR=float(value[1])),
        "conductor": lambda: metal(*value),
        "leaky": leaky,
        "osl": script,
    }[kind]()


def material_of(material, folder):
    out = bpy.data.materials.new("m")
    out.use_nodes = True
    nodes = Nodes(out.node_tree)
    nodes.add("ShaderNodeOutputMaterial", Surface=surface(nodes, material, folder))
    return out


def add_objects(scene, objects, folder):
    """Objects with the same mesh share its data; those of one are placed in doubles, as their corners are stored in 32 bits anyway."""
    uses, made, materials = {}, {}, {}
    for o in objects:
        uses[id(o.mesh)] = uses.get(id(o.mesh), 0) + 1
    for o in objects:
        shared = uses[id(o.mesh)] > 1
        if id(o.mesh) not in made:
            mesh = o.mesh
            positions = mesh.positions if shared else mesh.positions.astype(float) @ o.matrix[:3, :3].T + o.matrix[:3, 3]
            data = bpy.data.meshes.new("mesh")
            triangles = mesh.triangles if shared or np.linalg.det(o.matrix[:3, :3]) > 0 else mesh.triangles[:, ::-1]
            data.from_pydata(positions.astype(np.float32).tolist(), [], triangles.tolist())
            if mesh.uvs is not None:
                layer = data.uv_layers.new(name="uv")
                layer.data.foreach_set("uv", mesh.uvs[triangles.ravel()].ravel())
            if mesh.normals is not None:
                data.shade_smooth()
                data.normals_split_custom_set_from_vertices(mesh.normals.tolist())
            made[id(o.mesh)] = data
        if o.material not in materials:
            materials[o.material] = material_of(o.material, folder)
        placed = bpy.data.objects.new("object", made[id(o.mesh)])
        scene.collection.objects.link(placed)
        if not made[id(o.mesh)].materials:
            made[id(o.mesh)].materials.append(None)
        placed.material_slots[0].link = "OBJECT"
        placed.material_slots[0].material = materials[o.material]
        if shared:
            placed.matrix_world = mathutils.Matrix(o.matrix.tolist())


def add_sky(scene, what, folder):
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    nodes = Nodes(world.node_tree)
    if what is None or np.ndim(what) == 0:
        background = nodes.add("ShaderNodeBackground", Color=1.0, Strength=float(what or 0))
    else:
        # Its columns run the other way round and start on the other side.
        path = os.path.join(folder, "sky_cycles.exr")
        write_exr(path, np.repeat(np.roll(what, 256, 1)[:, ::-1, None], 3, 2))
        texture = nodes.add("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(path)
        texture.image.colorspace_settings.name = "Non-Color"
        texture.interpolation = "Closest"
        background = nodes.add("ShaderNodeBackground", Color=texture, Strength=1.0)
    nodes.add("ShaderNodeOutputWorld", Surface=background)


def shoot(scene, folder):
    path = os.path.join(folder, "cycles.exr")
    if os.path.exists(path):
        os.remove(path)
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    # A shader that does not compile is left out without an error.
    for name in os.listdir(folder):
        if name.endswith(".osl") and not os.path.exists(os.path.join(folder, name[:-1] + "o")):
            os.remove(os.path.join(folder, name))
            raise RuntimeError(f"{name} does not compile")
    return read_exr(path)


def add_camera(scene, **settings):
    data = bpy.data.cameras.new("camera")
    for name, value in settings.items():
        setattr(data, name, value)
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera


def aim_camera(scene, origin, target, hfov, **settings):
    """A camera with z up; hfov in degrees."""
    lens = 18 / np.tan(np.radians(hfov) / 2)
    camera = add_camera(scene, sensor_width=36, sensor_fit="HORIZONTAL", lens=float(lens), **settings)
    back = np.subtract(origin, target)
    back = back / np.linalg.norm(back)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = np.stack([right, np.cross(back, right), back], 1), origin
    camera.matrix_world = mathutils.Matrix(frame.tolist())


def render(what, folder):
    scene = fresh(what.size, what.samples, what.depth)
    add_objects(scene, what.objects, folder)
    add_sky(scene, what.sky, folder)
    distance = float(np.linalg.norm(what.target - what.origin))
    if distance < 2 * NEAREST:
        raise NotImplementedError("the camera stands nearer than 1e-6, its shortest clip distance")
    aim_camera(scene, what.origin, what.target, what.hfov, clip_start=distance * 1e-2, clip_end=distance * 1e4)
    return shoot(scene, folder)


CAMERA = """shader camera(output point position = 0, output vector direction = 0, output color throughput = 1)
{
    point r = camera_shader_raster_position();
    color o = texture("ORIGINS", r[0], 1 - r[1], "interp", "closest"), d = texture("DIRECTIONS", r[0], 1 - r[1], "interp", "closest");
    // A camera looks along -z.
    position = point(o[0], o[1], -o[2]);
    direction = vector(d[0], d[1], -d[2]);
}
"""


def leaks(placement, origins, directions, lengths, folder):
    """How many of these rays miss: n x n of them, one for each pixel. Too short ones are left out."""
    scene = fresh(len(origins), 1, 2)
    add_objects(scene, [scenes.Object(placement.mesh, scenes.Material("black"), m) for m in placement.matrices()], folder)
    add_sky(scene, 1.0, folder)
    text = CAMERA
    for name, pixels in (("ORIGINS", origins), ("DIRECTIONS", directions)):
        # Textures are cached by name.
        path = os.path.join(folder, f"{name.lower()}_{leaks.count}.exr")
        write_exr(path, pixels)
        text = text.replace(name, path)
    path = os.path.join(folder, f"camera_{leaks.count}.osl")
    leaks.count += 1
    with open(path, "w") as file:
        file.write(text)
    add_camera(scene, type="CUSTOM", custom_mode="EXTERNAL", custom_filepath=path, clip_start=NEAREST, clip_end=1e30)
    missed = shoot(scene, folder)[..., 0] > 0.5
    seen = lengths > 1.01 * NEAREST
    return int((missed & seen).sum()), int(seen.sum())


leaks.count = 0
