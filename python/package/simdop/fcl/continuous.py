"""When two moving objects meet."""

from __future__ import annotations

import math

import numpy as np

from .._arrays import Floats
from .enumerations import CCDMotionType
from .objects import CollisionObject, scene_of
from .requests import ContinuousCollisionRequest, ContinuousCollisionResult
from .transforms import Transform, from_quaternion, to_quaternion


def _turn(start: Floats, end: Floats) -> Floats:
    """The quaternion of the rotation from one pose to another."""
    return to_quaternion(end[:3, :3] @ start[:3, :3].T)


def _angle(q: Floats) -> float:
    return 2.0 * math.atan2(float(np.linalg.norm(q[1:])), abs(float(q[0])))


def _at(start: Floats, end: Floats, time: float, motion: int) -> Floats:
    """A pose of a motion. A translation keeps the rotation; other motions rotate about one axis."""
    pose = start.copy()
    pose[:3, 3] = (1 - time) * start[:3, 3] + time * end[:3, 3]
    if motion != CCDMotionType.CCDM_TRANS:
        q = _turn(start, end)
        axis, half = q[1:], math.atan2(float(np.linalg.norm(q[1:])), float(q[0])) * time
        if np.any(axis):
            turn = np.concatenate([[math.cos(half)], math.sin(half) * axis / np.linalg.norm(axis)])
            pose[:3, :3] = from_quaternion(turn) @ start[:3, :3]
    return pose


def continuousCollide(
    o1: CollisionObject,
    tf1_end: Transform,
    o2: CollisionObject,
    tf2_end: Transform,
    request: ContinuousCollisionRequest | None = None,
    result: ContinuousCollisionResult | None = None,
) -> float:
    """The first time, from 0 to 1, at which two objects that move to other poses meet; 1 if none.

    Conservative advancement, which misses no contact, ends at a distance of ``toc_err`` times the motion's length, or
    after a thousand steps. All motions but translations are treated as linear, with a rotation about one axis.
    """
    request = ContinuousCollisionRequest() if request is None else request
    result = ContinuousCollisionResult() if result is None else result
    motion = request.ccd_motion_type
    ends = tf1_end._matrix, tf2_end._matrix
    starts = o1._matrix, o2._matrix
    moves = [end[:3, 3] - start[:3, 3] for start, end in zip(starts, ends, strict=True)]
    speed = float(np.linalg.norm(moves[0] - moves[1]))
    if motion != CCDMotionType.CCDM_TRANS:
        for o, start, end in zip((o1, o2), starts, ends, strict=True):
            speed += _angle(_turn(start, end)) * o._geometry._reach()
    time, steps = 0.0, 0
    while True:
        at = [
            CollisionObject(o._geometry, Transform._from_matrix(_at(start, end, time, motion)))
            for o, start, end in zip((o1, o2), starts, ends, strict=True)
        ]
        gap = scene_of(at)[0].clearance().lower
        steps += 1
        if gap <= request.toc_err * speed or steps == 1000:
            result.is_collide = True
            result.time_of_contact = min(result.time_of_contact, time)
            return time
        if speed == 0.0 or gap >= speed * (1.0 - time):
            return 1.0
        time += gap / speed
