"""What a picture of a hard case shows, in words that every renderer has: camera, meshes, materials, sky.

In: nothing. Out: scenes, as tests/src/hard_cases/pictures.rs and tests/tests/hard_cases_*.rs make them. It must not know any renderer.
"""

from dataclasses import dataclass, field

import numpy as np

from meshes import sphere, wall


@dataclass(frozen=True)
class Material:
    """One of: diffuse(albedo), emitter(radiance), glow(radiance, albedo), black, metal (GGX of alpha 0.2, reflects 0.9), both (diffuse
    0.4 and anisotropic GGX 0.6), glass(ior), rough_glass(alpha, ior), conductor(n, k, alpha), leaky(of: diffuse, mirror, metal; lets
    0.001 through), osl(text that sets Ci)."""

    kind: str
    value: object = None
    albedo: float = 0.0


@dataclass
class Object:
    """A mesh in a place; objects with the same mesh share it."""

    mesh: object
    material: Material
    matrix: np.ndarray


@dataclass
class Scene:
    """Lengths in units, world space with z up; depth: edges of the longest path. sky: None, a radiance, or a map (rows from +z down,
    columns by atan2(y, x) from 0 to 2 pi)."""

    origin: np.ndarray = field(default_factory=lambda: np.array([0.0, -5.0, 0.0]))
    target: np.ndarray = field(default_factory=lambda: np.zeros(3))
    hfov: float = 20.0
    size: int = 16
    samples: int = 64
    depth: int = 8
    sky: object = None
    objects: list = field(default_factory=list)

    def put(self, mesh, material, matrix=None):
        self.objects.append(Object(mesh, material, np.eye(4) if matrix is None else matrix))
        return self


def affine(linear=1.0, move=(0, 0, 0)):
    """A 4 x 4 matrix from a scale, three scales or a 3 x 3 matrix, and a translation."""
    linear = np.asarray(linear, float)
    out = np.eye(4)
    out[:3, :3] = linear if linear.ndim == 2 else np.diag(linear * np.ones(3))
    out[:3, 3] = move
    return out


def turn(axis, angle):
    """Rotation about x (0) or z (2), right-handed, in radians."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) if axis == 0 else np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


HALF_TURN = np.diag([-1.0, -1.0, 1.0])
HALF = Material("diffuse", 0.5)
WHITE = Material("diffuse", 1.0)


def furnace(mesh, material, **more):
    """One mesh under a white sky, seen from 5 units away."""
    return Scene(sky=1.0, **more).put(mesh, material)


def spot(**more):
    """A spot of a wall of albedo 1/2 at the origin, seen along +y from so close that it is one point."""
    return Scene(hfov=0.02, depth=2, **more).put(wall(), HALF)


def hang(scene, mesh, radiance, size, h, matrix=HALF_TURN):
    """Hangs a lamp (front towards -y) behind the camera, so that it shines at the spot from distance h."""
    return scene.put(mesh, Material("emitter", radiance), affine(matrix * size, (0, -h, 0)))


def under_square(radiance, a, h):
    """Radiance of the spot under a square lamp of half side a at distance h (Howell's catalog of configuration factors, B-3)."""
    r = a / h
    s = np.sqrt(1 + r * r)
    return 0.5 * radiance * 4 / np.pi * (r / s) * np.arctan(r / s)


def lamp(radiance, size, h, samples):
    """A square lamp over the spot; the camera looks from between lamp and wall."""
    near = h * 0.5 if h < 1 else 5.0
    return hang(spot(samples=samples, origin=np.array([0.0, -near, 0.0])), wall(), radiance, size, h)


def corner(scale=1.0, shift=(0, 0, 0)):
    """A corner with a ball, a mirror, two shared squares and a lamp; scaled, then moved, its camera too."""
    white, metal = Material("diffuse", 0.7), Material("metal")
    shift, square = np.asarray(shift, float), wall()
    scene = Scene(hfov=40.0, samples=32, depth=6)
    scene.put(wall(), white, affine(2.0, (0, 1, 0)))
    scene.put(wall(), white, affine(2 * turn(0, -np.pi / 2), (0, 0, -1)))
    scene.put(wall(), Material("emitter", 8.0), affine(0.5 * turn(0, 1.2), (0, -0.5, 1.5)))
    scene.put(square, white, affine(0.4 * turn(2, 0.6), (-0.9, 0.2, 0.5)))
    scene.put(square, metal, affine(0.4 * turn(2, -0.6), (0.9, 0.2, 0.5)))
    scene.put(sphere(), metal, affine(0.5, (0.1, 0, -0.5)))
    for o in scene.objects:
        o.matrix = affine(scale, shift) @ o.matrix
    scene.origin, scene.target = scene.origin * scale + shift, scene.target * scale + shift
    return scene


def room(mesh, size, at):
    """Inside a closed room of white walls; a sky of 1e9 is outside."""
    at = np.array([at] * 3, float)
    scene = Scene(origin=at, target=at + np.array([0.3, 1.0, 0.2]) * size, hfov=120.0, depth=64, samples=8, sky=1e9)
    return scene.put(mesh, WHITE, affine(size * turn(2, 0.3), at))


def cover(gap):
    """A black cover in front of a lamp, 8 units from a wall that both see."""
    scene = Scene(depth=2).put(wall(), HALF)
    scene.put(wall(), Material("emitter", 1.0), affine(HALF_TURN, (0, -8, 0)))
    return scene.put(wall(), Material("black"), affine(1.5 * HALF_TURN, (0, -8 + gap, 0)))


def shining_room(mesh, samples):
    """A wall in a cube that shines inwards."""
    scene = Scene(origin=np.array([0.0, -0.65, 0.0]), hfov=80.0, depth=2, samples=samples)
    return scene.put(wall(), HALF).put(mesh, Material("emitter", 1.0))


def under_sky(sky, samples):
    """A wall under a sky."""
    return Scene(depth=2, samples=samples, sky=sky).put(wall(), HALF, affine(3.0))


def sky_map(rest, bright=0.0, where=None):
    """A map of 512 x 256 pixels of radiance `rest`, and of `bright` at the pixels `where` (row, column)."""
    out = np.full((256, 512), rest, np.float32)
    for row, column in where or []:
        out[row, column] = bright
    return out


def pixel_of(d):
    """Row and column of the map's pixel in a direction."""
    d = np.asarray(d) / np.linalg.norm(d)
    return int(np.arccos(d[2]) / np.pi * 256), int((np.arctan2(d[1], d[0]) / (2 * np.pi)) % 1 * 512)


def light_of(pixel):
    """How much light a pixel of the map brings to a wall that faces -y, over its radiance: the integral of -y over the pixel."""
    theta = np.pi * (np.array([pixel[0], pixel[0] + 1])) / 256
    phi = 2 * np.pi * np.array([pixel[1], pixel[1] + 1]) / 512
    sines = (theta - np.sin(2 * theta) / 2) / 2
    return (sines[1] - sines[0]) * (np.cos(phi[1]) - np.cos(phi[0]))


def inside_ball(mesh, of, samples):
    """From within a ball whose skin lets one path in a thousand out at each bounce."""
    scene = furnace(mesh, Material("leaky", of), depth=1000, samples=samples)
    scene.origin = np.array([0.0, -0.5, 0.0])
    return scene


def glowing(text):
    """A wall whose emission is an expression of OSL."""
    return Scene(samples=4, depth=1).put(wall(), Material("osl", text), affine(2.0))
