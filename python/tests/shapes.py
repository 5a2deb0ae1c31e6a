"""Meshes and poses for tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[np.int64]]


def box(x: float = 1.0, y: float = 1.0, z: float = 1.0) -> Mesh:
    """A closed box about the origin, with outward triangles."""
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float) - 0.5
    faces = [
        [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
        [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    ]  # fmt: skip
    return corners * [x, y, z], np.array(faces)


def ball(levels: int = 2, bump: float = 0.0) -> Mesh:
    """An octahedron, its triangles split in four and projected to the unit sphere; ``bump`` makes it uneven."""
    vertices = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    points = [np.array(v, float) for v in vertices]
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    for _ in range(levels):
        middles: dict[tuple[int, int], int] = {}

        def middle(i: int, j: int, middles: dict[tuple[int, int], int] = middles) -> int:
            key = (min(i, j), max(i, j))
            if key not in middles:
                p = points[i] + points[j]
                points.append(p / np.linalg.norm(p))
                middles[key] = len(points) - 1
            return middles[key]

        divided = []
        for i, j, k in faces:
            ij, jk, ki = middle(i, j), middle(j, k), middle(k, i)
            divided += [[i, ij, ki], [ij, j, jk], [ki, jk, k], [ij, jk, ki]]
        faces = divided
    table = np.array(points)
    return table * (1.0 + bump * np.sin(5.0 * table).sum(1, keepdims=True)), np.array(faces)


def at(x: float, y: float = 0.0, z: float = 0.0) -> Floats:
    """A translation, (4, 4)."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def poses(rng: np.random.Generator, count: int, reach: float) -> Floats:
    """Random rotations, with translations of a length up to ``reach``: (count, 4, 4)."""
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w, x, y, z = q.T
    made = np.zeros((count, 4, 4))
    made[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1)
    made[:, 1, :3] = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1)
    made[:, 2, :3] = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
    away = rng.normal(size=(count, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    made[:, :3, 3] = away * rng.uniform(0.0, reach, size=(count, 1))
    made[:, 3, 3] = 1.0
    return made
