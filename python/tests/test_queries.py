"""Queries of two bodies, against exact arithmetic and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import oracle
import simdop
from shapes import at, ball, box, poses
from simdop import Body

SMALL, UNEVEN = box(0.8, 0.9, 1.0), ball(1, 0.05)


def test_verdicts_and_contacts_are_those_of_exact_arithmetic(rng: np.random.Generator) -> None:
    a, b = Body(*SMALL), Body(*UNEVEN)
    hits = 0
    for pose in poses(rng, 60, 2.0):
        expected = oracle.meeting_pairs(SMALL, UNEVEN, pose)
        assert a.collide(b, pose) is bool(expected)
        found = a.contacts(b, pose)
        pairs = list(zip(found.index_a.tolist(), found.index_b.tolist(), strict=True))
        assert sorted(pairs) == sorted(expected)
        hits += bool(expected)
    assert 15 < hits < 58


@pytest.mark.parametrize("gap", [0.0, 2.0**-50, -(2.0**-50)])
def test_touching_is_meeting(gap: float) -> None:
    body, pose = Body(*box()), at(1.0 + gap)
    assert body.collide(body, pose) is (gap <= 0.0)
    assert (body.distance(body, pose).upper == 0.0) is (gap <= 0.0)


def test_distances_are_those_of_a_loop_over_all_pairs(rng: np.random.Generator) -> None:
    a, b = Body(*SMALL), Body(*UNEVEN)
    for pose in poses(rng, 12, 1.0):
        pose[:3, 3] *= 3.0 / np.linalg.norm(pose[:3, 3])
        found, expected = a.distance(b, pose), oracle.mesh_distance(SMALL, UNEVEN, pose)
        assert found.lower <= expected * (1 + 1e-12)
        assert found.upper >= expected * (1 - 1e-12)
        assert found.upper - found.lower <= 1e-11
        assert np.linalg.norm(found.point_a - found.point_b) == pytest.approx(expected, rel=1e-12)
        assert float(found) == found.upper
        # The witness is on the triangle that it names.
        triangle = oracle.moved(SMALL[0], pose)[SMALL[1]][found.index_a]
        plane = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        assert abs((found.point_a - triangle[0]) @ plane) <= 1e-12
        assert a.within(b, expected * (1 + 1e-9), pose)
        assert not a.within(b, expected * (1 - 1e-9), pose)


def test_tolerance_and_cutoff() -> None:
    body = Body(*ball(2))
    rough = body.distance(body, at(3.0), tolerance=0.5)
    assert rough.lower <= 1.0 <= rough.upper <= 1.5 * rough.lower
    beyond = body.distance(body, at(30.0), cutoff=1.0)
    assert beyond.lower >= 1.0
    assert beyond.upper == np.inf
    assert np.isnan(beyond.point_a).all()
    assert (beyond.index_a, beyond.index_b) == (-1, -1)
    for options in ({"tolerance": -1.0}, {"cutoff": np.nan}, {"tolerance": np.inf}):
        with pytest.raises(simdop.ToleranceError):
            body.distance(body, at(3.0), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("threads", [0, 1, 2, 7])
def test_arrays_of_poses_give_the_answers_of_single_ones(threads: int, rng: np.random.Generator) -> None:
    a, b, many = Body(*SMALL), Body(*UNEVEN), poses(rng, 300, 3.0)
    verdicts = a.collide(b, many, threads=threads)
    near = a.within(b, 0.3, many, threads=threads)
    found = a.distance(b, many, threads=threads)
    assert len(found) == 300
    assert 0 < verdicts.sum() < near.sum() < 300
    for i, pose in enumerate(many):
        one = a.distance(b, pose)
        assert verdicts[i] == a.collide(b, pose)
        assert near[i] == a.within(b, 0.3, pose)
        assert (found.lower[i], found.upper[i]) == (one.lower, one.upper)
        assert (found.index_a[i], found.index_b[i]) == (one.index_a, one.index_b)
        assert (found.point_a[i] == one.point_a).all()
        assert (found.point_b[i] == one.point_b).all()


def test_shapes_have_closed_forms() -> None:
    ball_, capsule, ground = Body.sphere(0.5), Body.capsule(0.25, 1.0), Body.half_space([0, 0, 1])
    for z in (0.1, 0.5, 0.75, 1.5, 4.0):
        assert ball_.distance(ground, at(0, 0, z)).upper == pytest.approx(max(z - 0.5, 0.0), abs=1e-12)
        assert ball_.collide(ground, at(0, 0, z)) is (z <= 0.5)
        assert ground.collide(ball_, at(0, 0, -z)) is (z <= 0.5)
        assert capsule.distance(ball_, at(z)).upper == pytest.approx(max(z - 0.75, 0.0), abs=1e-12)


KINDS = {
    "mesh": Body(*box(), solid=True),
    "shape": Body.box([1, 1, 1]),
    "shapes": Body.shapes([Body.box([1, 1, 0.5], at=at(0, 0, 0.25)), Body.box([1, 1, 0.5], at=at(0, 0, -0.25))]),
    "spheres": Body.spheres([[0.0, 0.0, 0.0]], [0.5]),
    "cloud": Body.cloud([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]]),
}


@pytest.mark.parametrize("a", KINDS)
@pytest.mark.parametrize("b", KINDS)
def test_every_kind_against_every_other(a: str, b: str) -> None:
    if a == b == "cloud":
        for ask in (KINDS[a].collide, KINDS[a].distance):
            with pytest.raises(simdop.BodyError, match="two clouds"):
                ask(KINDS[b])
        return
    # All extend from -1/2 to 1/2 along x, so that they touch at a distance of 1.
    for x, gap in [(0.75, 0.0), (1.25, 0.25), (-1.5, 0.5)]:
        found = KINDS[a].distance(KINDS[b], at(x))
        assert found.upper == pytest.approx(gap, abs=1e-12)
        assert KINDS[a].collide(KINDS[b], at(x)) is (gap == 0.0)
        assert KINDS[a].within(KINDS[b], gap + 1e-9, at(x))
        if gap > 0.0:
            assert not KINDS[a].within(KINDS[b], gap - 1e-9, at(x))
            assert (found.point_a - found.point_b)[0] == pytest.approx(np.copysign(gap, x), abs=1e-12)
        if gap == 0.0 and "cloud" not in (a, b):
            assert len(KINDS[a].contacts(KINDS[b], at(x))) >= 1


def test_contacts_have_points_normals_and_depths() -> None:
    a, b = Body.sphere(1.0), Body.box([2, 2, 2])
    contacts = a.contacts(b, at(0, 0, 1.75))
    assert len(contacts) == 1
    assert contacts.depths == pytest.approx([0.25], abs=1e-5)
    assert contacts.normals[0] == pytest.approx([0, 0, 1], abs=1e-3)
    mesh = Body(*box())
    for contact in [mesh.contacts(mesh, at(0.5, 0.25, 0.125)), mesh.contacts(mesh, at(0.5, 0.25, 0.125), limit=1)]:
        assert np.linalg.norm(contact.normals, axis=1) == pytest.approx(1.0)
        assert (np.abs(contact.points) <= 0.5 + 1e-6).all()
    assert len(mesh.contacts(mesh, at(0.5), limit=3)) == 3
    assert len(mesh.contacts(mesh, at(0.5), limit=0)) == 0
    assert len(mesh.contacts(mesh, at(1.5))) == 0


def test_penetration_of_two_spheres_is_a_lens() -> None:
    one = Body.spheres([[0, 0, 0]], 1.0)
    found = one.penetration(one, at(1.0))
    assert found.volume == pytest.approx(5 / 12 * np.pi, rel=1e-14)
    assert found.direction.tolist() == [1.0, 0.0, 0.0]
    assert found.point.tolist() == [0.5, 0.0, 0.0]
    assert found.pairs == 1
    many = one.penetration(one, np.stack([at(x) for x in np.linspace(0, 3, 50)]), threads=2)
    d = np.linspace(0, 3, 50)
    lens = np.where(d < 2, np.pi / 12 * (2 - d) ** 2 * (d * d + 4 * d) / np.where(d > 0, d, 1), 0.0)
    lens[0] = 4 / 3 * np.pi
    assert many.volume == pytest.approx(lens, abs=1e-13)
    assert np.isnan(many.point[-1]).all()
    with pytest.raises(simdop.BodyError, match=r"Body\.pack"):
        Body(*box()).penetration(one)


def test_packings_share_volume_as_boxes_do() -> None:
    packed = Body(*box()).pack(800)
    filled = float((4 / 3 * np.pi * packed.radii**3).sum())
    assert 0.75 < filled < 1.0
    whole = packed.penetration(packed).volume
    assert whole == pytest.approx(filled, rel=1e-9)
    half = packed.penetration(packed, at(0.5)).volume
    assert 0.25 < half < 0.5


def test_answers_have_texts() -> None:
    body = Body(*box())
    assert repr(body.distance(body, at(1.5))).startswith("Distance(0.4999999999")
    assert repr(body.distance(body, np.stack([at(1.5), at(2.0)]))).startswith("Distance(at 2 poses, least 0.5")
    assert repr(body.contacts(body, at(5.0))) == "Contacts(0 pairs of primitives, at most 0 deep)"
    with pytest.raises(TypeError, match="several poses"):
        float(body.distance(body, np.stack([at(1.5)])))
    with pytest.raises(TypeError, match="one pose"):
        len(body.distance(body, at(1.5)))
