"""Rays at the edges and corners of closed meshes, by the rule of tests/src/hard_cases/rays.cl, and the placements of its test.

In: nothing. Out: placements and arrays of rays. Corners are taken to world space in doubles and rounded to 32-bit floats, as a renderer
holds them; rays are aimed from rounded origins in doubles, so that what they miss is the renderer's error.
"""

from dataclasses import dataclass

import numpy as np

from meshes import ball, cube, needles
from scenes import affine, turn


@dataclass
class Placement:
    """A closed mesh around the origin, where it stands, where the camera stands; `shared`: one of two copies that share triangles."""

    name: str
    mesh: object
    matrix: np.ndarray
    camera: np.ndarray
    shared: bool
    thin: float = 0.0  # share of rays into it that may fall through, as our test allows

    @property
    def unit(self):
        """A fifth of the camera's distance."""
        return np.linalg.norm(self.camera - self.matrix[:3, 3]) / 5

    def matrices(self):
        """Of all copies: the other one is far away along x."""
        if not self.shared:
            return [self.matrix]
        far = self.matrix.copy()
        far[0, 3] += 1e3 * np.linalg.norm(self.matrix[:3, 0])
        return [self.matrix, far]

    def corners(self):
        """In world space, of each triangle."""
        world = self.mesh.positions.astype(float) @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return world.astype(np.float32)[self.mesh.triangles].astype(float)


def turned(*scale):
    return affine(turn(2, 0.7) @ turn(0, 0.4) @ np.diag(scale))


def placements():
    away, near, one = np.array([1e7, -2e7, 0.5e7]), np.array([0.0, -5.0, 0.0]), ball(48, 24)
    moved = affine(1, away)
    out = [
        ("ball", one, affine(), near, False),
        ("cube along the axes", cube(8), affine(), near, False),
        ("ball from 1,000 of its radii", one, affine(), near * 200, False),
        ("ball, scale 1e-6", one, turned(1e-6, 1e-6, 1e-6), near * 1e-6, False),
        ("ball, scale 1e6", one, turned(1e6, 1e6, 1e6), near * 1e6, False),
        ("ball 1e7 away with its camera", one, moved, away + near, False),
        ("shared ball", one, turned(1, 1, 1), near, True),
        ("shared ball, scale 1e-6", one, turned(1e-6, 1e-6, 1e-6), near * 1e-6, True),
        ("shared ball, scale 1e6", one, turned(1e6, 1e6, 1e6), near * 1e6, True),
        ("shared ball 1e7 away with its camera", one, moved, away + near, True),
        ("mirrored shared ball", one, turned(-1, 2, 0.5), near, True),
        ("shared ball, scales 1000 : 1 : 0.001", one, turned(1e3, 1, 1e-3), near, True, 0.3),
        ("ball, scales 1000 : 1 : 0.001", one, turned(1e3, 1, 1e-3), near, False, 0.3),
        ("shared ball, scales 1e6 : 1 : 1", one, affine((1e6, 1, 1)), near, True),
        ("shared ball, scales 1 : 1 : 1e-6", one, affine((1, 1, 1e-6)), near, True, 0.01),
        ("ball, scales 1e6 : 1 : 1", one, affine((1e6, 1, 1)), near, False, 0.03),
        ("ball of needles", needles(), affine(), near, False),
    ]
    return [Placement(*p) for p in out]


def rounded(o, target):
    """Origins and unit directions in 32-bit floats, and lengths; those without a direction become copies of the first."""
    o = o.astype(np.float32)
    d = target - o.astype(float)
    length = np.linalg.norm(d, axis=-1, keepdims=True)
    d = (d / np.where(length > 0, length, 1)).astype(np.float32)
    return copies(length[:, 0] > 0, o, d, length[:, 0])


def copies(good, *arrays):
    """The arrays with a good entry in the place of each that is not."""
    if not good.any():
        raise NotImplementedError("no ray of this case can be said in 32-bit floats")
    index = np.where(good, np.arange(len(good)), np.argmax(good))
    return [a[index] for a in arrays]


def aim(placement, count, draw, inside_only=False):
    """Places on edges anywhere, in the middles of edges, in corners and inside triangles, in equal parts; with corners and middle."""
    corners, middle = placement.corners(), placement.matrix[:3, 3].astype(np.float32).astype(float)
    i = np.arange(count)
    p = corners[(draw(count) * len(corners)).astype(int)]
    k = (i >> 3) % 3
    a, b = p[i, k], p[i, (k + 1) % 3]
    x, y = draw((count, 1)), draw((count, 1))
    inside = p[:, 0] + (p[:, 1] - p[:, 0]) * x + (p[:, 2] - p[:, 0]) * ((1 - x) * y)
    edges = [(i % 4 == m)[:, None] & (not inside_only) for m in range(3)]
    return np.select(edges, [a + (b - a) * x, (a + b) / 2, a], inside), corners, middle


def aimed(placement, count, seed, reach=0.9, inside=False):
    """Rays from within. They start between the middle and the part `reach` of the way to the surface. `inside`: to insides of triangles only."""
    draw = np.random.default_rng(seed).random
    target, corners, middle = aim(placement, count, draw, inside)
    other = corners[(draw(count) * len(corners)).astype(int), (np.arange(count) >> 5) % 3]
    return rounded(middle + (other - middle) * (draw((count, 1)) * reach), target)


def axial(placement, count, seed):
    """The same along the axis in which the place is farthest out; only from places that are inside for sure."""
    target, _, middle = aim(placement, count, np.random.default_rng(seed).random)
    v = np.abs(target - middle)
    away = np.eye(3)[np.argmax(v, 1)]
    good = ((v * (1 - away)).max(1) <= 0.55 * v.max(1)) & (v.max(1) > 0)
    o, d = target * (1 - away) + middle * away, np.sign((target - middle) * away)
    return copies(good, o.astype(np.float32), d.astype(np.float32), v.max(1))
