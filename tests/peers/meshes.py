"""The meshes of the hard cases, as tests/src/hard_cases/meshes.rs and tests/src/scenes.rs make them, and PLY files of them.

In: nothing. Out: meshes around the origin, corners in 32-bit floats. It must not know what is asked of them, nor any renderer.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Mesh:
    """Corners (n x 3), triangles (m x 3); normals and texture coordinates for each corner, or None."""

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    uvs: np.ndarray | None = None

    def __post_init__(self):
        self.positions = np.asarray(self.positions, np.float32).reshape(-1, 3)
        self.triangles = np.asarray(self.triangles, np.int32).reshape(-1, 3)
        if self.normals is not None:
            self.normals = np.asarray(self.normals, np.float32).reshape(-1, 3)
        if self.uvs is not None:
            self.uvs = np.asarray(self.uvs, np.float32).reshape(-1, 2)


def wall(normals=None, uvs=((0, 0), (1, 0), (1, 1), (0, 1))):
    """The square from -1 to 1 in x and z at y = 0, its front towards -y."""
    return Mesh("wall", [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[0, 1, 2], [0, 2, 3]], normals, uvs)


def ball(across, down):
    """A closed ball of radius 1 whose poles each join `across` triangles; convex, no two triangles in one plane."""
    positions = [[0.0, 0.0, 1.0]]
    for j in range(1, down):
        for i in range(across):
            theta, phi = np.pi * j / down, 2 * np.pi * (i + 0.5 * (j % 2)) / across
            positions.append([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    positions.append([0.0, 0.0, -1.0])
    last = len(positions) - 1
    at = lambda j, i: 1 + (j - 1) * across + i % across
    triangles = []
    for i in range(across):
        triangles.append([0, at(1, i), at(1, i + 1)])
        for j in range(1, down - 1):
            a, b, c, d = at(j, i), at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)
            triangles += [[a, c, b], [b, c, d]] if j % 2 == 0 else [[a, c, d], [a, d, b]]
        triangles.append([last, at(down - 1, i + 1), at(down - 1, i)])
    return Mesh("ball", positions, triangles)


def cube(n, inwards=False, size=1.0):
    """A closed cube from -size to size, each side n x n squares; corners are shared by all sides."""
    positions, known, triangles = [], {}, []

    def place(p):
        if p not in known:
            known[p] = len(positions)
            positions.append(p)
        return known[p]

    for axis in range(3):
        for side in (-1.0, 1.0):

            def at(i, j):
                p = [side] * 3
                p[(axis + 1) % 3], p[(axis + 2) % 3] = -1.0 + 2.0 * i / n, -1.0 + 2.0 * j / n
                return place(tuple(p))

            for i in range(n):
                for j in range(n):
                    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
                    triangles += [[a, b, c], [a, c, d]] if (side > 0) != inwards else [[a, c, b], [a, d, c]]
    return Mesh("cube", np.array(positions) * size, triangles)


def needles():
    """A closed ball with rings of triangles a million times longer than wide, and some without any area."""
    mesh = ball(24, 12)
    positions, out = list(mesh.positions), []
    for k, (a, b, c) in enumerate(mesh.triangles):
        p, q, r = (mesh.positions[i] for i in (a, b, c))
        inside = [p * np.float32(1 - 2e-6) + q * np.float32(1e-6) + r * np.float32(1e-6), (p + q + r) / np.float32(3), p][k % 3]
        if k % 3 == 0:
            inside = inside / np.linalg.norm(inside)
        m = len(positions)
        positions.append(inside)
        out += [[a, b, m], [b, c, m], [c, a, m]]
    return Mesh("needles", np.array(positions), out)


def grid(n):
    """The wall, cut n times each way."""
    u, v = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n)
    uvs = np.stack([u.ravel(), v.ravel()], -1)
    positions = np.stack([2 * uvs[:, 0] - 1, 0 * uvs[:, 0], 2 * uvs[:, 1] - 1], -1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(n), np.arange(n)))
    a = j * (n + 1) + i
    b, c, d = a + 1, a + n + 2, a + n + 1
    return Mesh("grid", positions, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]), None, uvs)


def dust():
    """A grid with three triangles that have no area."""
    mesh = grid(4)
    first = len(mesh.positions)
    positions = np.concatenate([mesh.positions, [[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0]]])
    triangles = np.concatenate([mesh.triangles, [[first] * 3, [first, first + 2, first + 3], [first, first + 1, first + 2]]])
    return Mesh("dust", positions, triangles, None, np.concatenate([mesh.uvs, np.zeros((4, 2))]))


def sphere():
    """A ball of radius 1 with smooth normals."""
    across, down = 48, 24
    j, i = (x.ravel() for x in np.meshgrid(np.arange(down + 1), np.arange(across), indexing="ij"))
    theta, phi = np.pi * j / down, 2 * np.pi * i / across
    positions = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    at = lambda j, i: j * across + i % across
    triangles = []
    for j in range(down):
        for i in range(across):
            triangles += [[at(j, i), at(j + 1, i), at(j + 1, i + 1)], [at(j, i), at(j + 1, i + 1), at(j, i + 1)]]
    return Mesh("sphere", positions, triangles, positions)


def write_ply(mesh, path):
    """Binary PLY, the same file for every renderer that reads one."""
    columns, names = [mesh.positions], ["x", "y", "z"]
    if mesh.normals is not None:
        columns.append(mesh.normals)
        names += ["nx", "ny", "nz"]
    if mesh.uvs is not None:
        columns.append(mesh.uvs)
        names += ["u", "v"]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    head += [f"property float {n}" for n in names]
    head += [f"element face {len(mesh.triangles)}", "property list uchar int vertex_indices", "end_header"]
    faces = np.zeros(len(mesh.triangles), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    faces["n"], faces["i"] = 3, mesh.triangles
    with open(path, "wb") as file:
        file.write(("\n".join(head) + "\n").encode())
        file.write(np.concatenate(columns, 1).astype("<f4").tobytes())
        file.write(faces.tobytes())
