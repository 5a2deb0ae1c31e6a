"""Compares depths with those of convex decompositions: ``python -m simdop.bench --depth MESH...``.

Coal and python-fcl give depths of convex bodies. Their users decompose other meshes, here with CoACD, and take the
deepest pair of parts. That may differ from the depth of the meshes both ways: the parts fill hollows, and a translation
that separates one pair may drive another deeper.

Coal's exact verdicts on the meshes themselves decide what is true: the sampled depth is the shortest translation, of
those tried, after which it calls the meshes free.
"""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ._arrays import Floats, Triangles
from ._simdop import Body
from .agreement import coal_model

Mesh = tuple[Floats, Triangles]
Answer = tuple[float, Floats]
"""A depth and the translation of A by it, both zero without an answer."""

_NONE: Answer = 0.0, np.zeros(3)
_TRIALS = 2000
"""Translations tried for one sampled depth."""


class _Truth:
    """Verdicts of Coal on the meshes."""

    def __init__(self, coal: Any, mesh: Mesh) -> None:
        self._coal, self._tree, self._still = coal, coal_model(coal, mesh), coal.Transform3s()
        self._request = coal.CollisionRequest()
        # Coal counts bodies as meeting that are closer than about 1e-6.
        self._slack = 1e-5 * float(np.linalg.norm(np.ptp(mesh[0], axis=0)))

    def is_free(self, pose: Floats, by: Floats) -> bool:
        """Whether the meshes do not meet after a translation."""
        at = self._coal.Transform3s(pose[:3, :3], pose[:3, 3] + by)
        result = self._coal.CollisionResult()
        return not self._coal.collide(self._tree, at, self._tree, self._still, self._request, result)

    def frees(self, pose: Floats, by: Floats) -> bool:
        """Whether a translation, or one that is a little longer, separates the meshes."""
        length = np.linalg.norm(by)
        return bool(length > 0) and self.is_free(pose, by * (1 + self._slack / length))

    def depth(self, pose: Floats, known: list[Floats], rng: np.random.Generator) -> float:
        """The length of the shortest free translation tried: those known, and random ones that are shorter."""
        best = min((float(np.linalg.norm(t)) for t in known if self.frees(pose, t)), default=np.inf)
        if not np.isfinite(best):
            raise ValueError("no translation is known")
        along = [t / np.linalg.norm(t) for t in known if np.linalg.norm(t) > 0]
        for trial in range(_TRIALS):
            direction = rng.normal(size=3)
            if trial % 2 == 1:
                # Near the best direction.
                direction = along[-1] + 0.3 * rng.uniform() * direction / np.linalg.norm(direction)
            direction /= np.linalg.norm(direction)
            length = best * (1 - rng.uniform() ** 2)
            if self.is_free(pose, length * direction):
                best = length
                along.append(direction)
        return best


def _deep_poses(body: Body, count: int, deep: float, rng: np.random.Generator) -> list[Floats]:
    """Random orientations and directions; along these, first contact and then ``deep`` farther."""
    poses: list[Floats] = []
    reach = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    while len(poses) < count:
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        pose, direction = np.eye(4), rng.normal(size=3)
        pose[:3, :3] = axes * np.sign(np.linalg.det(axes))
        direction /= np.linalg.norm(direction)
        centre = body.vertices.mean(axis=0)
        pose[:3, 3] = centre - pose[:3, :3] @ centre + 1.5 * reach * direction
        for _ in range(200):
            gap = float(body.distance(body, pose, tolerance=0.01).lower)
            if gap < 1e-6 * reach:
                break
            pose[:3, 3] -= gap * direction
        pose[:3, 3] -= deep * reach * direction
        if body.collide(body, pose):
            poses.append(pose)
    return poses


def _coal_depth(coal: Any, parts: list[Mesh]) -> Callable[[Floats], Answer]:
    """The deepest pair of convex parts, by Coal."""
    hulls = []
    for part in parts:
        model = coal_model(coal, part)
        model.buildConvexHull(True, "Qt")
        model.convex.computeLocalAABB()
        hulls.append((model.convex, *_ball(part[0])))
    still = coal.Transform3s()

    def depth(pose: Floats) -> Answer:
        at = coal.Transform3s(pose[:3, :3], pose[:3, 3])
        best = _NONE
        for a, b in _near(hulls, pose):
            result, request = coal.CollisionResult(), coal.CollisionRequest(coal.CollisionRequestFlag.CONTACT, 1)
            if coal.collide(a, at, b, still, request, result):
                contact = result.getContact(0)
                if -contact.penetration_depth > best[0]:
                    # The normal points from A to B.
                    best = -contact.penetration_depth, contact.penetration_depth * np.array(contact.normal)
        return best

    return depth


def _fcl_depth(fcl: Any, parts: list[Mesh]) -> Callable[[Floats], Answer]:
    """The deepest pair of convex parts, by FCL."""
    hulls = []
    for vertices, faces in parts:
        flat = np.concatenate([[3, *face] for face in faces])
        hulls.append((fcl.Convex(vertices, len(faces), flat), *_ball(vertices)))
    still = fcl.Transform()

    def depth(pose: Floats) -> Answer:
        at = fcl.Transform(pose[:3, :3], pose[:3, 3])
        best = _NONE
        for a, b in _near(hulls, pose):
            result, request = fcl.CollisionResult(), fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
            if fcl.collide(fcl.CollisionObject(a, at), fcl.CollisionObject(b, still), request, result):
                contact = result.contacts[0]
                if contact.penetration_depth > best[0]:
                    best = contact.penetration_depth, -contact.penetration_depth * np.array(contact.normal)
        return best

    return depth


def _ball(points: Floats) -> tuple[Floats, float]:
    """The centre and the radius of a sphere around points."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    return centre, float(np.linalg.norm(points - centre, axis=1).max())


def _near(hulls: list[tuple[Any, Floats, float]], pose: Floats) -> list[tuple[Any, Any]]:
    """Pairs of parts whose spheres meet."""
    centres, radii = np.array([h[1] for h in hulls]), np.array([h[2] for h in hulls])
    moved = centres @ pose[:3, :3].T + pose[:3, 3]
    gaps = np.linalg.norm(moved[:, None] - centres[None], axis=2) - radii[:, None] - radii[None]
    return [(hulls[i][0], hulls[j][0]) for i, j in np.argwhere(gaps <= 0)]


def _decompose(coacd: Any, mesh: Mesh) -> list[Mesh]:
    """CoACD's parts, by its default settings."""
    coacd.set_log_level("error")
    return [(np.array(v), np.array(f)) for v, f in coacd.run_coacd(coacd.Mesh(*mesh))]


def _quantile(values: Floats, q: float) -> str:
    return f"{np.quantile(values, q):.3g}" if len(values) else ""


def _row(name: str, spent: list[float], answers: list[Answer], true: list[float], frees: list[bool]) -> None:
    ratios = np.array([answer[0] / depth for answer, depth in zip(answers, true, strict=True)])
    print(
        f"| {name} | {np.median(spent) * 1e6:.0f} | {np.quantile(spent, 0.95) * 1e6:.0f} | {_quantile(ratios, 0)} "
        f"| {_quantile(ratios, 0.05)} | {_quantile(ratios, 0.5)} | {_quantile(ratios, 0.95)} | {_quantile(ratios, 1)} "
        f"| {sum(frees)} of {len(frees)} |"
    )


def compare(paths: list[Path], count: int, spheres: int = 2000, budget: int = 2000) -> bool:
    """Print the tables of some meshes. Whether a bound of simdop is wrong."""
    coal, coacd = importlib.import_module("coal"), importlib.import_module("coacd")
    try:
        fcl = importlib.import_module("fcl")
    except ImportError:
        fcl = None
    is_wrong = False
    for path in paths:
        body = Body.load(path, solid=True)
        mesh = body.vertices, body.faces.astype(np.int64)
        start = time.perf_counter()
        parts = _decompose(coacd, mesh)
        decomposed = time.perf_counter() - start
        start = time.perf_counter()
        packed = body.with_packing(spheres)
        filled = time.perf_counter() - start
        truth = _Truth(coal, mesh)
        print(f"\n{path.stem}: {len(mesh[1])} triangles. CoACD: {len(parts)} parts in {decomposed:.1f} s.", end=" ")
        print(f"Packing of {spheres} spheres: {filled:.1f} s.")
        ways: dict[str, Callable[[Floats], Answer]] = {"Coal, parts": _coal_depth(coal, parts)}
        if fcl:
            ways["python-fcl, parts"] = _fcl_depth(fcl, parts)
        for deep in (0.01, 0.05):
            rng = np.random.default_rng(1)
            poses = _deep_poses(body, count, deep, rng)
            spent: dict[str, list[float]] = {}
            answers: dict[str, list[Answer]] = {}
            lowers: list[Answer] = []
            for pose in poses:
                start = time.perf_counter()
                found = packed.depth(packed, pose, budget=budget)
                spent.setdefault("simdop, upper bound", []).append(time.perf_counter() - start)
                upper = float(found.upper)
                answers.setdefault("simdop, upper bound", []).append(
                    (upper, found.translation) if np.isfinite(upper) else _NONE
                )
                lowers.append((float(found.lower), np.zeros(3)))
                for name, depth in ways.items():
                    start = time.perf_counter()
                    answer = depth(pose)
                    spent.setdefault(name, []).append(time.perf_counter() - start)
                    answers.setdefault(name, []).append(answer)
            true = []
            for i, pose in enumerate(poses):
                # A direction in which a long translation is surely free.
                far = pose[:3, 3] / np.linalg.norm(pose[:3, 3]) * 3 * np.ptp(mesh[0], axis=0).max()
                true.append(truth.depth(pose, [far, *(tried[i][1] for tried in answers.values())], rng))
            print(f"\n| moved in {deep:.0%} | us | p95 | least / sampled | 5 % | median | 95 % | most | frees |")
            print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
            for name, given in answers.items():
                frees = [truth.frees(pose, t) for pose, (_, t) in zip(poses, given, strict=True)]
                _row(name, spent[name], given, true, frees)
                if name == "simdop, upper bound":
                    _row("simdop, lower bound", spent[name], lowers, true, [])
            below = [given[0] > depth * (1 + 1e-6) for given, depth in zip(lowers, true, strict=True)]
            if any(below):
                print(f"error: {sum(below)} lower bounds are above the sampled depth", file=sys.stderr)
                is_wrong = True
    return is_wrong
