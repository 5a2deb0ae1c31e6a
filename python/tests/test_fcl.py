"""``simdop.fcl``, against closed forms and python-fcl."""

from __future__ import annotations

from typing import Any

import fcl as peer
import numpy as np
import pytest

import simdop.fcl as fcl
from shapes import ball, box, poses

QUADS = [[0, 3, 2, 1], [4, 5, 6, 7], [4, 7, 3, 0], [5, 1, 2, 6], [4, 0, 1, 5], [7, 6, 2, 3]]
CORNERS = [[-1, -1, -1], [-1, 1, -1], [-1, 1, 1], [-1, -1, 1], [1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]


def mesh(library: Any, vertices: Any, faces: Any) -> Any:
    """A mesh of python-fcl, or of its replacement."""
    model = library.BVHModel()
    model.beginModel(len(faces), len(vertices))
    model.addSubModel(vertices, faces)
    model.endModel()
    return model


def geometries(library: Any) -> dict[str, Any]:
    """The same geometries in either library."""
    faces = np.array([[4, *quad] for quad in QUADS]).ravel()
    return {
        "box": library.Box(1.0, 0.8, 0.6),
        "sphere": library.Sphere(0.6),
        "capsule": library.Capsule(0.3, 0.8),
        "cylinder": library.Cylinder(0.5, 0.8),
        "cone": library.Cone(0.6, 0.9),
        "convex": library.Convex(0.5 * np.array(CORNERS, float), 6, faces),
        "mesh": mesh(library, *ball(1, 0.05)),
    }


OURS, THEIRS = geometries(fcl), geometries(peer)


@pytest.mark.parametrize("a", OURS)
@pytest.mark.parametrize("b", OURS)
def test_verdicts_and_distances_are_those_of_python_fcl(a: str, b: str, rng: np.random.Generator) -> None:
    meeting = 0
    for pose in poses(rng, 12, 2.5):
        rotation, shift = pose[:3, :3], pose[:3, 3]
        mine = fcl.CollisionObject(OURS[a], fcl.Transform(rotation, shift)), fcl.CollisionObject(OURS[b])
        his = peer.CollisionObject(THEIRS[a], peer.Transform(rotation, shift)), peer.CollisionObject(THEIRS[b])
        result = fcl.DistanceResult()
        found = fcl.distance(*mine, fcl.DistanceRequest(True), result)
        # Here, a convex solid that contains a whole mesh is a hit; a mesh's surface does not meet what it contains.
        expected = peer.distance(*his, peer.DistanceRequest(True), peer.DistanceResult())
        if abs(expected) > 1e-4:
            assert (fcl.collide(*mine) > 0) is (peer.collide(*his) > 0)
            assert max(found, 0.0) == pytest.approx(max(expected, 0.0), abs=2e-3)
        meeting += found <= 0.0
        if found > 0.0:
            p, q = result.nearest_points
            assert p is not None
            assert q is not None
            assert np.linalg.norm(p - q) == pytest.approx(found, abs=1e-9)
    assert 0 < meeting < 12


def test_depths_have_closed_forms() -> None:
    request = fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True)
    cube = geometries(fcl)["convex"]
    still = fcl.CollisionObject(cube)
    rows: list[tuple[Any, list[float], float]] = [
        (cube, [0.75, 0, 0], 0.25),
        (fcl.Sphere(0.5), [0.9, 0, 0], 0.1),
        (fcl.Box(1, 1, 1), [0, 0.6, 0], 0.4),
        (fcl.Cylinder(0.5, 1.0), [0, 0, 0.7], 0.3),
        (fcl.Cone(0.5, 1.0), [0, 0, 0.8], 0.2),
        (fcl.Halfspace(np.array([0.0, 0, 1]), 0.0), [0, 0, -0.4], 0.1),
        (fcl.Capsule(0.25, 1.0), [0, 0, 1.2], 0.05),
    ]
    for geometry, shift, depth in rows:
        moved = fcl.CollisionObject(geometry, fcl.Transform(np.array(shift)))
        for pair in [(moved, still), (still, moved)]:
            result = fcl.DistanceResult()
            assert fcl.distance(*pair, request, result) == pytest.approx(-depth, abs=1e-6)
            found = fcl.CollisionResult()
            fcl.collide(*pair, fcl.CollisionRequest(1, True), found)
            # Moved apart by the depth along the normal, they touch; moved a bit less, they still meet.
            contact = found.contacts[0]
            assert contact.penetration_depth == pytest.approx(depth, abs=1e-6)
            for scale, meets in [(1 + 1e-4, False), (1 - 1e-4, True)]:
                away = pair[1].getTranslation() + scale * depth * contact.normal
                other = fcl.CollisionObject(pair[1].collision_geometry, fcl.Transform(away))
                assert (fcl.collide(pair[0], other) > 0) is meets


def test_transforms_are_those_of_python_fcl(rng: np.random.Generator) -> None:
    for pose in poses(rng, 50, 2.0):
        mine, his = fcl.Transform(pose[:3, :3], pose[:3, 3]), peer.Transform(pose[:3, :3], pose[:3, 3])
        q = mine.getQuatRotation()
        assert np.abs(q @ his.getQuatRotation()) == pytest.approx(1.0)
        assert fcl.Transform(q).getRotation() == pytest.approx(pose[:3, :3])
        assert fcl.Transform(q, pose[:3, 3]).getTranslation().tolist() == pose[:3, 3].tolist()
        assert fcl.Transform(mine).getRotation().tolist() == pose[:3, :3].tolist()
    for arguments in [(np.zeros(5),), (np.eye(3), np.zeros(4)), (1, 2, 3)]:
        with pytest.raises(ValueError, match=r"Transform|Translation"):
            fcl.Transform(*arguments)


def test_motions_stop_at_contact() -> None:
    cube = fcl.Box(1, 1, 1)
    a, b = fcl.CollisionObject(cube, fcl.Transform(np.array([-3.0, 0, 0]))), fcl.CollisionObject(cube)
    for end, expected in [(1.0, 0.5), (-1.5, 1.0), (9.0, 2 / 12)]:
        result = fcl.ContinuousCollisionResult()
        found = fcl.continuousCollide(
            a, fcl.Transform(np.array([end, 0, 0])), b, fcl.Transform(), fcl.ContinuousCollisionRequest(), result
        )
        assert found == pytest.approx(expected, abs=1e-3)
        assert found <= expected
        assert result.is_collide is (expected < 1.0)
    # A bar that rotates by a quarter turn about z sweeps over a ball beside it.
    bar = fcl.CollisionObject(fcl.Box(4, 0.1, 0.1))
    aside = fcl.CollisionObject(fcl.Sphere(0.25), fcl.Transform(np.array([1.0, 1.0, 0])))
    turned = fcl.Transform(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    linear = fcl.ContinuousCollisionRequest(ccd_motion_type=fcl.CCDMotionType.CCDM_LINEAR)
    assert 0.2 < fcl.continuousCollide(bar, turned, aside, aside.getTransform(), linear) < 0.5


def test_what_has_no_queries_says_so() -> None:
    ellipsoid = fcl.CollisionObject(fcl.Ellipsoid(1, 2, 3))
    with pytest.raises(NotImplementedError, match="Ellipsoid"):
        fcl.collide(ellipsoid, fcl.CollisionObject(fcl.Sphere(1)))
    with pytest.raises(NotImplementedError, match="Halfspace"):
        fcl.collide(fcl.CollisionObject(fcl.Plane(np.array([0.0, 0, 1]), 0)), fcl.CollisionObject(fcl.Sphere(1)))
    with pytest.raises(ValueError, match="geometry"):
        fcl.CollisionObject()
    model = fcl.BVHModel()
    with pytest.raises(ValueError, match="sequence"):
        model.addVertex(0, 0, 0)
    with pytest.raises(ValueError, match="fewer faces"):
        fcl.Convex(np.zeros((3, 3)), 2, [3, 0, 1, 2])


def test_shapes_may_change() -> None:
    ball_ = fcl.Sphere(1.0)
    pair = fcl.CollisionObject(ball_), fcl.CollisionObject(fcl.Sphere(1.0), fcl.Transform(np.array([3.0, 0, 0])))
    assert fcl.distance(*pair) == pytest.approx(1.0)
    ball_.radius = 1.5
    assert fcl.distance(*pair) == pytest.approx(0.5)
    assert len(box()[1]) == 12
