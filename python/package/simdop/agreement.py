"""Compares verdicts and distances at many poses with Coal's: ``python -m simdop.bench --agree POSES``."""

from __future__ import annotations

import importlib
import time
from typing import Any

import numpy as np

from ._arrays import Floats, Triangles
from ._simdop import Body

Mesh = tuple[Floats, Triangles]

_TOLERANCE = 1e-6
"""Coal stops at this distance from contact, and its distances are off by as much."""


def coal_model(coal: Any, mesh: Mesh) -> Any:
    """A mesh as Coal's tree of oriented boxes."""
    vertices, faces = mesh
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(len(faces), len(vertices))
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(vertices))
    triangles.extend([coal.Triangle(*map(int, face)) for face in faces])
    tree.addSubModel(points, triangles)
    tree.endModel()
    return tree


def revolved(radius: Floats, height: Floats, around: int, bump: float = 0.0) -> Mesh:
    """A closed surface of rings about z, whose first and last radius are 0; ``bump`` makes it uneven."""
    turn = 2 * np.pi * np.arange(around) / around
    wide = 1 + bump * np.sin(3 * turn)
    rings = [np.stack([r * wide * np.cos(turn), r * wide * np.sin(turn), np.full(around, z)], axis=1)
             for r, z in zip(radius[1:-1], height[1:-1], strict=True)]  # fmt: skip
    points = np.concatenate([[[0, 0, height[0]]], *rings, [[0, 0, height[-1]]]])
    faces, last = [], len(points) - 1

    def at(i: int, j: int) -> int:
        return 1 + i * around + j % around

    for j in range(around):
        faces += [[0, at(0, j + 1), at(0, j)], [last, at(len(rings) - 1, j), at(len(rings) - 1, j + 1)]]
        for i in range(len(rings) - 1):
            faces += [[at(i, j), at(i, j + 1), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i + 1, j)]]
    return points, np.array(faces)


def ring(around: int, across: int) -> Mesh:
    """A torus."""
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij")
    wide = 0.75 + 0.25 * np.cos(v)
    points = np.stack([wide * np.cos(u), wide * np.sin(u), 0.25 * np.sin(v)], axis=2).reshape(-1, 3)
    faces = []
    for i in range(around):
        for j in range(across):
            p, q = i * across + j, (i + 1) % around * across + j
            r, s = i * across + (j + 1) % across, (i + 1) % around * across + (j + 1) % across
            faces += [[p, q, s], [p, s, r]]
    return points, np.array(faces)


def five() -> dict[str, Mesh]:
    """Meshes of a few hundred triangles about the origin, with a radius of about 1."""
    u = np.linspace(0, np.pi, 17)
    steps = np.array([0, 0.9, 0.9, 0.3, 0.3, 0.7, 0])
    levels = np.array([-0.9, -0.9, -0.5, -0.4, 0.5, 0.6, 0.9])
    return {
        "ball": revolved(np.sin(u), np.cos(u)[::-1], 16),
        "star": revolved(np.sin(u) * (1 + 0.3 * np.cos(4 * u)), np.cos(u)[::-1], 18, 0.4),
        "spool": revolved(steps, levels, 24),
        "plate": revolved(np.array([0, 1.0, 1.0, 0]), np.array([-0.02, -0.02, 0.02, 0.02]), 48, 0.1),
        "ring": ring(24, 12),
    }


def random_poses(count: int, near: float, far: float, seed: int) -> Floats:
    """Random rotations, at distances from ``near`` to ``far`` from the origin: (count, 4, 4)."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    q[:, :, 0] *= np.linalg.det(q)[:, None]
    away = rng.normal(size=(count, 3))
    away *= (rng.uniform(near, far, size=count) / np.linalg.norm(away, axis=1))[:, None]
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = q, away
    return poses


def compare(count: int) -> int:
    """Print how verdicts and distances at ``count`` poses differ from Coal's; return how many are wrong.

    Each of five meshes is tested against the next one. Verdicts at poses nearer to contact than Coal's tolerance are
    not compared. Distances of bodies that meet are 0.
    """
    coal = importlib.import_module("coal")
    meshes = five()
    names = list(meshes)
    bodies = {name: Body(*mesh) for name, mesh in meshes.items()}
    trees = {name: coal_model(coal, mesh) for name, mesh in meshes.items()}
    still, wrong = coal.Transform3s(), 0
    print("\n| pair | poses | in contact | left out | other verdicts | other distances | greatest difference |"
          " simdop, us | Coal, us |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|")  # fmt: skip
    for i, (a, b) in enumerate(zip(names, names[1:] + names[:1], strict=True)):
        poses = random_poses(count // len(names), 0.6, 2.4, i)
        start = time.perf_counter()
        hits, gaps = bodies[a].collide(bodies[b], poses), bodies[a].distance(bodies[b], poses).upper
        mine = time.perf_counter() - start
        start = time.perf_counter()
        hit, gap = np.zeros(len(poses), bool), np.zeros(len(poses))
        for k, pose in enumerate(poses):
            placed = coal.Transform3s(pose[:3, :3], pose[:3, 3])
            pair = (trees[a], placed, trees[b], still)
            hit[k] = coal.collide(*pair, coal.CollisionRequest(), coal.CollisionResult())
            gap[k] = coal.distance(*pair, coal.DistanceRequest(), coal.DistanceResult())
        his = time.perf_counter() - start
        clear = hits | (gaps > _TOLERANCE)
        verdicts = int(np.sum((hit != hits) & clear))
        off = np.abs(np.maximum(gap, 0.0) - gaps)
        distances = int(np.sum((off > _TOLERANCE) & ~hits))
        wrong += verdicts + distances
        print(f"| {a}, {b} | {len(poses)} | {hits.sum()} | {int(np.sum(~clear))} | {verdicts} | {distances}"
              f" | {off[~hits].max(initial=0.0):.2g} | {mine / len(poses) * 1e6:.1f}"
              f" | {his / len(poses) * 1e6:.1f} |")  # fmt: skip
    print(
        f"\n{wrong} of {2 * (count // len(names)) * len(names)} answers differ. Times are of a verdict and a distance."
    )
    return wrong
