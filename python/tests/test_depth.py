"""Depths, signed distances and patches, against closed forms and differences of hulls."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import oracle
import simdop
from oracle import Floats
from shapes import at, ball, box, poses
from simdop import Body

CUBE = Body(*box(), solid=True)


def depth_of_hulls(a: Floats, b: Floats) -> float:
    """The depth of two hulls: how far the origin is inside their Minkowski difference; 0 outside."""
    difference = (a[:, None, :] - b[None, :, :]).reshape(-1, 3)
    return max(float(-ConvexHull(difference).equations[:, 3].max()), 0.0)


@pytest.mark.parametrize("other", [CUBE, Body.box([1, 1, 1]), Body.hull(box()[0])])
@pytest.mark.parametrize("body", [CUBE, Body.box([1, 1, 1]), Body.hull(box()[0])])
def test_boxes_have_closed_forms(body: Body, other: Body) -> None:
    for x, y, deep, axis in [(0.75, 0.125, 0.25, 0), (-0.1, 0.9, 0.1, 1), (0.5, 0.25, 0.5, 0)]:
        found = body.depth(other, at(x, y, 0.0625))
        assert found.upper == pytest.approx(deep, abs=1e-9)
        assert 0.98 * deep <= found.lower <= found.upper
        assert float(found) == found.upper
        assert found.is_complete is True
        way = np.zeros(3)
        way[axis] = np.copysign(deep, x if axis == 0 else y)
        assert found.translation == pytest.approx(way, abs=1e-6)
        signed = body.signed_distance(other, at(x, y, 0.0625))
        assert signed.lower == pytest.approx(-deep, abs=1e-9)
        assert float(signed) == signed.lower
        assert signed.normal == pytest.approx(way / deep, abs=1e-6)
        assert (signed.point_a - signed.point_b) @ signed.normal == pytest.approx(-deep, abs=1e-6)
        assert body.depth_along(other, [0, 0, 5.0], at(x, y, 0.0625)) == pytest.approx(0.9375, abs=1e-7)
    apart = body.signed_distance(other, at(0, -1.75))
    assert apart.lower == pytest.approx(0.75, abs=1e-12)
    assert apart.upper == pytest.approx(0.75, abs=1e-12)
    assert apart.normal == pytest.approx([0, -1, 0])
    assert body.depth(other, at(0, -1.75)).upper == 0.0
    assert body.depth_along(other, [1, 0, 0], at(0, -1.75)) == 0.0


def test_packings_bring_the_bounds_closer() -> None:
    vertices, faces = box()
    for solid in (CUBE, Body(vertices, faces[1:], solid=True, caps=2.0)):
        packed = solid.with_packing(30)
        there = np.array([[0.8, 0.6, 0, 0.875], [-0.6, 0.8, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        plain, found = solid.depth(solid, there, budget=100), packed.depth(packed, there, budget=100)
        assert 0 < plain.lower < found.lower <= packed.depth(packed, there).upper
        for copy in (Body.from_bytes(packed.to_bytes()), pickle.loads(pickle.dumps(packed))):
            assert copy.to_bytes() == packed.to_bytes()
            assert copy.depth(copy, there, budget=100).lower == found.lower
        assert packed.signed_distance(solid, at(0, -1.75)).upper == solid.signed_distance(solid, at(0, -1.75)).upper
    for other in (Body(vertices, faces), Body.hull(vertices), Body.sphere(1.0)):
        with pytest.raises(simdop.Error, match=r"Body\.with_packing takes a"):
            other.with_packing(5)
    with pytest.raises(simdop.BuildError, match="no spheres"):
        CUBE.with_packing(0)


def test_hulls_have_the_depth_of_their_difference(rng: np.random.Generator) -> None:
    meeting = 0
    for pose in poses(rng, 60, 2.0):
        a, b = rng.normal(size=(2, 12, 3)) * 0.5
        first, second = Body.hull(a), Body.hull(b)
        found, moved = first.depth(second, pose), oracle.moved(a, pose)
        expected = depth_of_hulls(moved, b)
        assert found.lower <= expected + 1e-12
        assert found.upper >= expected - 1e-12
        assert found.upper - found.lower <= 1e-11
        signed = first.signed_distance(second, pose)
        meeting += expected > 0.0
        if expected > 0.0:
            assert signed.lower == pytest.approx(-expected, abs=1e-11)
            # After the translation, slightly lengthened for rounding, they do not meet.
            out = pose.copy()
            out[:3, 3] += found.translation * (1 + 1e-9)
            assert not first.collide(second, out)
        else:
            near = first.distance(second, pose)
            assert signed.upper == pytest.approx(near.upper, abs=1e-11)
            assert np.linalg.norm(signed.point_a - signed.point_b) == pytest.approx(near.upper, abs=1e-9)
    assert 10 < meeting < 55


def test_hulls_are_exact_solids(rng: np.random.Generator) -> None:
    points = rng.normal(size=(50, 3))
    hull = Body.hull(points)
    assert hull.kind == "hull"
    assert hull.is_solid
    assert len(hull.faces) == len(ConvexHull(points).simplices)
    assert hull.collide(Body.sphere(1e-3), at(0))
    again = pickle.loads(pickle.dumps(hull))
    assert again.kind == "hull"
    assert again.to_bytes() == hull.to_bytes()
    assert not Body.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0]]).is_solid
    with pytest.raises(simdop.BuildError):
        Body.hull([[np.nan, 0, 0]])


def test_shapes_have_closed_forms() -> None:
    sphere, ground = Body.sphere(0.5), Body.half_space([0, 0, 1])
    for z in (-0.25, 0.25, 0.5, 2.0):
        for body in (sphere, Body.spheres([[0, 0, 0]], 0.5), Body(*box(), solid=True), Body.hull(box()[0])):
            found = body.signed_distance(ground, at(0, 0, z))
            assert found.lower == pytest.approx(z - 0.5, abs=1e-11)
            assert found.upper == pytest.approx(z - 0.5, abs=1e-11)
            assert ground.signed_distance(body, at(0, 0, -z)).lower == pytest.approx(z - 0.5, abs=1e-11)
    pair = sphere.signed_distance(Body.capsule(0.25, 1.0), at(0.5, 0, 0.25))
    assert pair.lower == pytest.approx(-0.25, abs=1e-12)
    assert pair.gradient[:3] == pytest.approx([1, 0, 0], abs=1e-9)
    assert sphere.depth_along(ground, [0, 1, 1], at(0, 0, 0.25)) == pytest.approx(0.25 * np.sqrt(2), abs=1e-9)
    assert sphere.depth_along(ground, [0, 0, -1], at(0, 0, 0.25)) == np.inf


def test_gradients_are_those_of_differences(rng: np.random.Generator) -> None:
    a, b = Body.hull(ball(1)[0] * 0.6), Body.box([1.0, 0.8, 0.6])
    smooth = total = 0
    for pose in poses(rng, 40, 1.4):
        found = a.signed_distance(b, pose)
        for i in range(6):
            step, ends = 1e-6, []
            for sign in (1, -1):
                nudged, axis = pose.copy(), np.eye(3)[i % 3]
                if i < 3:
                    nudged[:3, 3] += sign * step * axis
                else:
                    turn = np.eye(3) + sign * step * np.cross(axis, np.eye(3)).T
                    nudged[:3, :] = turn @ nudged[:3, :]
                ends.append(float(a.signed_distance(b, nudged)))
            total += 1
            smooth += abs((ends[0] - ends[1]) / (2 * step) - found.gradient[i]) < 1e-3
    assert smooth > 0.95 * total


FIGURES = np.array([
    [0x3FDFFFFFFFFFF00E, 0x3FE0000000007F75, 0xBFE0000000007F75, 0xBFDFFFFFFFFFF00E, 0x3FF0000000000000,
     0x0000000000000000, 0x0000000000000000, 0x8000000000000000, 0x3FD8000000000000, 0x3FD0000000000000],
    [0x3FE3FFFFFFFFF7D2, 0x3FE4000000009F5E, 0xBFE4000000009F5E, 0xBFE3FFFFFFFFF7D2, 0x0000000000000000,
     0x0000000000000000, 0x3FF0000000000000, 0xBFD4CCCCCCCCCCCC, 0xBFE7333333333334, 0x0000000000000000],
    [0x0000000000000000, 0x0000000000000000, 0x3FEB211B1C70C9AA, 0x3FEB211B1C70D072, 0x3FEC4F1128CEC2ED,
     0x3FDC4F1128CEC2ED, 0xBFC2DF60C5DF2C9E, 0x3FB2DF60C5DF2C9E, 0xBFCC4F1128CEC2ED, 0xBFCC4F1128CEC2EC],
], np.uint64)  # fmt: skip
"""Bounds of depths and signed distances, and derivatives, as bits: those of tests/contact_depth/scenes.rs."""


def test_figures_are_those_of_rust_bit_for_bit() -> None:
    a, b = Body(*box(), solid=True), Body(*box(1.5, 1.25, 0.75), solid=True)
    turned = at(0.625, 0.375, 0.25)
    turned[:2, :2] = [[0.6, -0.8], [0.8, 0.6]]
    for pose, bits in zip((at(0.75, 0.25, 0.125), turned, at(2.0, 1.5, -1.0)), FIGURES, strict=True):
        depth, signed = a.depth(b, pose), a.signed_distance(b, pose)
        found = np.array([depth.lower, depth.upper, signed.lower, signed.upper, *signed.gradient])
        assert found.view(np.uint64).tolist() == bits.tolist()


def test_no_shorter_translation_of_meshes_is_free(rng: np.random.Generator) -> None:
    a, b = Body(*ball(2, 0.05), solid=True), Body(*box(1.5, 1.0, 1.0), solid=True)
    for pose in poses(rng, 12, 0.8):
        found = a.depth(b, pose)
        assert 0 < found.lower <= found.upper
        out = pose.copy()
        out[:3, 3] += found.translation
        assert not a.collide(b, out)
        ways = rng.normal(size=(300, 3))
        ways *= found.lower * rng.uniform(size=(300, 1)) / np.linalg.norm(ways, axis=1, keepdims=True)
        shorter = np.tile(pose, (300, 1, 1))
        shorter[:, :3, 3] += ways
        assert a.collide(b, shorter).all()
        rough = a.depth(b, pose, budget=200)
        assert rough.lower <= found.lower
        assert rough.upper >= found.upper


@pytest.mark.parametrize("threads", [0, 1, 3])
def test_arrays_of_poses_give_the_answers_of_single_ones(threads: int, rng: np.random.Generator) -> None:
    many = poses(rng, 40, 1.5)
    for a, b in [(CUBE, CUBE), (Body.hull(ball(1)[0]), Body.box([1, 1, 1]))]:
        depths = a.depth(b, many, threads=threads)
        signed = a.signed_distance(b, many, threads=threads)
        along = a.depth_along(b, [1, 1, 0], many, threads=threads)
        assert len(depths) == len(signed) == len(along) == 40
        assert signed.gradient.shape == (40, 6)
        for i, pose in enumerate(many):
            one, other = a.depth(b, pose), a.signed_distance(b, pose)
            assert (depths.lower[i], depths.upper[i], depths.is_complete[i]) == (one.lower, one.upper, one.is_complete)
            assert (depths.translation[i] == one.translation).all()
            assert (signed.lower[i], signed.upper[i]) == (other.lower, other.upper)
            for name in ("normal", "point_a", "point_b", "gradient"):
                assert np.array_equal(getattr(signed, name)[i], getattr(other, name), equal_nan=True)
            assert along[i] == a.depth_along(b, [1, 1, 0], pose)
    patches = CUBE.patches(CUBE, many, threads=threads)
    assert [len(found) for found in patches] == [len(CUBE.patches(CUBE, pose)) for pose in many]


def test_a_box_on_a_box_touches_in_four_corners() -> None:
    small = Body(*box(0.5, 0.5, 0.5), solid=True)
    (patch,) = small.patches(CUBE, at(0, 0, 0.75))
    corners = sorted(patch.points.tolist())
    expected = [[x, y, 0.5] for x in (-0.25, 0.25) for y in (-0.25, 0.25)]
    assert np.abs(np.array(corners) - expected).max() < 1e-12
    assert patch.normal == pytest.approx([0, 0, 1])
    assert patch.area == pytest.approx(0.25)
    assert patch.depth == pytest.approx(0.0, abs=1e-9)
    assert len(small.patches(CUBE, at(0, 0, 0.75), points=2)[0].points) == 2
    (deeper,) = small.patches(CUBE, at(0, 0, 0.625))
    assert deeper.depth == pytest.approx(0.125, abs=1e-7)
    assert deeper.centre[2] == pytest.approx(0.5)
    assert CUBE.patches(CUBE, at(3)) == []
    with pytest.raises(simdop.BodyError, match="two meshes"):
        CUBE.patches(Body.sphere(1.0))


def test_scenes_are_signed() -> None:
    scene = simdop.Scene()
    first, second = scene.add(Body.sphere(0.5)), scene.add(Body.sphere(0.5), at(0.75))
    scene.add(CUBE, at(5.0))
    found = scene.signed_clearance()
    assert found.lower == pytest.approx(-0.25, abs=1e-12)
    assert found.bodies is not None
    assert set(found.bodies) == {first, second}
    assert found.normal is not None
    assert found.normal == pytest.approx([-1, 0, 0] if found.bodies[0] == first else [1, 0, 0])
    assert found.gradient is None
    scene.move(second, at(2.0))
    assert float(scene.signed_clearance()) == pytest.approx(1.0)
    assert scene.signed_clearance(cutoff=0.5).bodies is None
    with pytest.raises(simdop.SceneError):
        scene.signed_clearance(tolerance=-1.0)


def test_bad_input_is_refused() -> None:
    cloud = Body.cloud([[0, 0, 0]])
    asks: list[Any] = [cloud.depth, cloud.signed_distance]
    for ask in asks:
        with pytest.raises(simdop.BodyError, match="two clouds"):
            ask(cloud)
    for tolerance in (-1.0, np.nan, np.inf):
        for a in (CUBE, Body.hull(box()[0]), Body.sphere(1.0)):
            with pytest.raises(simdop.ToleranceError):
                a.signed_distance(CUBE, tolerance=tolerance)
    with pytest.raises(simdop.ArrayError, match=r"\(3,\)"):
        CUBE.depth_along(CUBE, [1, 0])
    assert CUBE.depth_along(CUBE, [0, 0, 0]) == np.inf
    with pytest.raises(simdop.ArrayError, match=r"\(n, 4, 4\)"):
        CUBE.depth(CUBE, np.eye(3))
    assert CUBE.depth(CUBE, np.zeros((0, 4, 4))).upper.shape == (0,)
    with pytest.raises(TypeError, match="several poses"):
        float(CUBE.depth(CUBE, at(1.0)[None]))
    with pytest.raises(TypeError, match="one pose"):
        len(CUBE.signed_distance(CUBE))
    assert repr(CUBE.depth(CUBE, at(3.0))) == "Depth(0 ..= 0, translation [0.0, 0.0, 0.0])"
