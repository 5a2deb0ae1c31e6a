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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._arrays import Floats, Triangles
from ._simdop import Body
from .agreement import coal_model, random_poses

Mesh = tuple[Floats, Triangles]
_TRIALS = 2000
"""Translations tried for one sampled depth."""


@dataclass(frozen=True)
class Answer:
    """A depth, and the translation of A by it: both zero without an answer. Some libraries give a lower bound, too."""

    depth: float
    translation: Floats
    lower: float | None = None


_NONE = Answer(0.0, np.zeros(3))


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


def _deep_poses(body: Body, count: int, deep: float) -> list[Floats]:
    """At most ``count`` random orientations and directions; along these, first contact and then ``deep`` farther."""
    poses: list[Floats] = []
    reach = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    centre = body.vertices.mean(axis=0)
    for pose in random_poses(count, 1.5 * reach, 1.5 * reach, 1):
        direction = pose[:3, 3] / np.linalg.norm(pose[:3, 3])
        pose[:3, 3] += centre - pose[:3, :3] @ centre
        for _ in range(200):
            gap = float(body.distance(body, pose, tolerance=0.01).lower)
            if gap < 1e-6 * reach:
                break
            pose[:3, 3] -= gap * direction
        pose[:3, 3] -= deep * reach * direction
        if body.collide(body, pose):
            poses.append(pose)
    return poses


def _simdop_depth(body: Body, budget: int) -> Callable[[Floats], Answer]:
    """The interval that simdop proves."""

    def depth(pose: Floats) -> Answer:
        found = body.depth(body, pose, budget=budget)
        known = bool(np.isfinite(found.upper))
        return Answer(float(found.upper) if known else 0.0, found.translation, float(found.lower))

    return depth


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
                if -contact.penetration_depth > best.depth:
                    # The normal points from A to B.
                    translation = contact.penetration_depth * np.array(contact.normal)
                    best = Answer(-contact.penetration_depth, translation)
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
                if contact.penetration_depth > best.depth:
                    translation = -contact.penetration_depth * np.array(contact.normal)
                    best = Answer(contact.penetration_depth, translation)
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


def _row(name: str, spent: list[float], depths: list[float], sampled: list[float], frees: str) -> None:
    times = np.quantile(spent, [0.5, 0.95]) * 1e6
    ratios = np.quantile(np.array(depths) / sampled, [0, 0.05, 0.5, 0.95, 1])
    print(f"| {name} | {times[0]:.0f} | {times[1]:.0f} | {' | '.join(f'{x:.3g}' for x in ratios)} | {frees} |")


def _table(ways: dict[str, Callable[[Floats], Answer]], truth: _Truth, poses: list[Floats], far: float) -> bool:
    """Print a row for each library. Whether a lower bound is wrong."""
    spent: dict[str, list[float]] = {name: [] for name in ways}
    answers: dict[str, list[Answer]] = {name: [] for name in ways}
    for pose in poses:
        for name, depth in ways.items():
            start = time.perf_counter()
            answers[name].append(depth(pose))
            spent[name].append(time.perf_counter() - start)
    rng, sampled = np.random.default_rng(1), []
    for i, pose in enumerate(poses):
        # A long translation is surely free.
        known = [pose[:3, 3] / np.linalg.norm(pose[:3, 3]) * far, *(given[i].translation for given in answers.values())]
        sampled.append(truth.depth(pose, known, rng))
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
    is_wrong = False
    for name, given in answers.items():
        frees = sum(truth.frees(pose, answer.translation) for pose, answer in zip(poses, given, strict=True))
        _row(name, spent[name], [answer.depth for answer in given], sampled, f"{frees} of {len(poses)}")
        lowers = [answer.lower for answer in given if answer.lower is not None]
        if lowers:
            _row(f"{name}, lower bound", spent[name], lowers, sampled, "")
            is_wrong |= bool(np.any(np.array(lowers) > np.array(sampled) * (1 + 1e-6)))
    return is_wrong


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
        print(f"\n{path.stem}: {len(mesh[1])} triangles. CoACD: {len(parts)} parts in {decomposed:.1f} s.", end=" ")
        print(f"Packing of {spheres} spheres: {filled:.1f} s.")
        ways = {"simdop": _simdop_depth(packed, budget), "Coal, parts": _coal_depth(coal, parts)}
        if fcl:
            ways["python-fcl, parts"] = _fcl_depth(fcl, parts)
        truth, far = _Truth(coal, mesh), 3 * float(np.ptp(mesh[0], axis=0).max())
        for deep in (0.01, 0.05):
            print(f"\n| moved in {deep:.0%} | us | p95 | least / sampled | 5 % | median | 95 % | most | frees |")
            is_wrong |= _table(ways, truth, _deep_poses(body, count, deep), far)
    if is_wrong:
        print("error: a lower bound is above the sampled depth", file=sys.stderr)
    return is_wrong
