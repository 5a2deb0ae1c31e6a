"""Whether two objects meet, and how far apart they are."""

from __future__ import annotations

import sys

import numpy as np

from .._arrays import Floats
from .contacts import bare_contact, find_contacts
from .objects import CollisionObject, scene_of
from .requests import CollisionRequest, CollisionResult, DistanceRequest, DistanceResult


def collide(
    o1: CollisionObject,
    o2: CollisionObject,
    request: CollisionRequest | None = None,
    result: CollisionResult | None = None,
) -> int:
    """Find contacts of two objects, at most ``num_max_contacts``; return their number."""
    request = CollisionRequest() if request is None else request
    result = CollisionResult() if result is None else result
    scene, _ = scene_of((o1, o2))
    if not scene.collide():
        return 0
    result.is_collision = True
    if request.num_max_contacts <= 0:
        return 0
    found = find_contacts(o1, o2, request.num_max_contacts) if request.enable_contact else [bare_contact(o1, o2)]
    result.contacts += found
    return len(found)


def _overlap(o1: CollisionObject, o2: CollisionObject, is_signed: bool) -> tuple[float, list[Floats | None], int, int]:
    """What ``distance`` returns for two objects that meet."""
    if o1._is_mesh() and o2._is_mesh():
        found = find_contacts(o1, o2, 1)
        first = found[0] if found else bare_contact(o1, o2)
        return 0.0, [first.pos, first.pos], first.b1, first.b2
    if not is_signed:
        return -1.0, [np.zeros(3), np.zeros(3)], -1, -1
    deepest = max(find_contacts(o1, o2, sys.maxsize), key=lambda contact: contact.penetration_depth)
    half = 0.5 * deepest.penetration_depth * deepest.normal
    return -deepest.penetration_depth, [deepest.pos + half, deepest.pos - half], deepest.b1, deepest.b2


def distance(
    o1: CollisionObject,
    o2: CollisionObject,
    request: DistanceRequest | None = None,
    result: DistanceResult | None = None,
) -> float:
    """The distance of two objects.

    Of objects that meet, it is 0 for two meshes; else minus their depth if ``enable_signed_distance``, else -1.
    """
    request = DistanceRequest() if request is None else request
    result = DistanceResult() if result is None else result
    scene, known = scene_of((o1, o2))
    near = scene.clearance()
    points: list[Floats | None] = [None, None]
    b1 = b2 = -1
    if near.upper == 0.0:
        least, points, b1, b2 = _overlap(o1, o2, request.enable_signed_distance)
    else:
        least = near.upper
        if near.bodies is not None and near.points is not None and near.indices is not None:
            first = 0 if known[near.bodies[0]] is o1 else 1
            points = [near.points[first], near.points[1 - first]]
            b1 = o1._triangle(near.indices[first])
            b2 = o2._triangle(near.indices[1 - first])
    if least < result.min_distance:
        result.min_distance = least
        result.nearest_points = points
        result.o1, result.o2 = o1._geometry, o2._geometry
        result.b1, result.b2 = b1, b2
    return least
