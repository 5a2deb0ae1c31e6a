"""Scenes, against queries of all pairs."""

from __future__ import annotations

import numpy as np
import pytest

import simdop
from shapes import at, ball, box, poses
from simdop import Body, Scene

BODIES = [Body(*box(), solid=True), Body(*ball(1)), Body.sphere(0.4), Body.capsule(0.2, 0.8)]


def filled(rng: np.random.Generator, count: int, reach: float) -> tuple[Scene, dict[int, tuple[Body, np.ndarray]]]:
    """A scene of bodies at random poses, and its contents."""
    scene, known = Scene(), {}
    for i, pose in enumerate(poses(rng, count, reach)):
        body = BODIES[i % len(BODIES)]
        known[scene.add(body, pose)] = (body, pose)
    return scene, known


def gap(a: tuple[Body, np.ndarray], b: tuple[Body, np.ndarray]) -> float:
    """The distance of two bodies at poses in the world."""
    return float(a[0].distance(b[0], np.linalg.inv(b[1]) @ a[1]))


def test_pairs_and_clearance_are_those_of_all_pairs(rng: np.random.Generator) -> None:
    for reach in (3.0, 6.0, 30.0):
        scene, known = filled(rng, 12, reach)
        gaps = {(i, j): gap(known[i], known[j]) for i in known for j in known if i < j}
        for margin in (0.0, 0.5):
            found = {tuple(sorted(pair)) for pair in scene.pairs(margin)}
            assert found == {pair for pair, d in gaps.items() if d <= margin}
            assert scene.collide(margin) is bool(found)
        near = scene.clearance()
        assert float(near) == pytest.approx(min(gaps.values()), abs=1e-12)
        if float(near) > 0.0:
            assert near.bodies is not None
            assert near.points is not None
            assert gaps[tuple(sorted(near.bodies))] == pytest.approx(float(near))  # type: ignore[index]
            assert np.linalg.norm(near.points[0] - near.points[1]) == pytest.approx(float(near))


def test_two_scenes_are_tested_against_each_other_only(rng: np.random.Generator) -> None:
    (one, of_one), (other, of_other) = filled(rng, 9, 4.0), filled(rng, 7, 4.0)
    gaps = {(i, j): gap(of_one[i], of_other[j]) for i in of_one for j in of_other}
    assert set(one.pairs(other=other)) == {pair for pair, d in gaps.items() if d == 0.0}
    assert set(other.pairs(other=one)) == {pair[::-1] for pair, d in gaps.items() if d == 0.0}
    assert one.collide(other=other) is (min(gaps.values()) == 0.0)
    far = Scene()
    number = far.add(BODIES[0], at(50.0))
    near = one.clearance(other=far)
    assert near.bodies is not None
    assert near.bodies[1] == number
    assert float(near) == pytest.approx(min(gap(body, (BODIES[0], at(50.0))) for body in of_one.values()))
    # A scene against itself: every body meets itself.
    assert {(i, i) for i in of_one} <= set(one.pairs(other=one))


def test_bodies_move_come_and_go() -> None:
    scene = Scene()
    table, hand, cup = scene.add(BODIES[0], fixed=True), scene.add(BODIES[0], at(3.0)), scene.add(BODIES[2], at(4.5))
    assert scene.numbers == sorted([table, hand, cup])
    assert len(scene) == 3
    assert not scene.collide()
    scene.attach(cup, hand)
    scene.allow_collision(hand, cup)
    scene.move(hand, at(-1.25))
    assert scene.pose(cup)[:3, 3] == pytest.approx([0.25, 0, 0])
    assert [tuple(sorted(pair)) for pair in scene.pairs()] == [(table, cup)]
    with pytest.raises(simdop.SceneError, match="attached"):
        scene.move(cup, at(9.0))
    scene.detach(cup)
    scene.forbid_collision(hand, cup)
    copy = scene.copy()
    scene.remove(cup)
    assert cup not in scene
    assert not scene.collide()
    assert copy.collide()
    for ask in (scene.remove, scene.pose, scene.body):
        with pytest.raises(simdop.SceneError):
            ask(cup)
    assert scene.add(BODIES[1], at(9.0)) != cup
    assert scene.body(table).kind == "mesh"
    assert repr(scene) == "Scene(3 bodies)"


def test_radii_groups_and_fixed_bodies() -> None:
    scene = Scene()
    a = scene.add(BODIES[2], at(0.0), radius=0.1)
    b = scene.add(BODIES[2], at(1.0), radius=0.1)
    assert scene.pairs() == [(a, b)] or scene.pairs() == [(b, a)]
    with pytest.raises(simdop.SceneError, match="radius"):
        scene.add(BODIES[2], radius=-1.0)
    apart = Scene()
    apart.add(BODIES[0], fixed=True)
    apart.add(BODIES[0], fixed=True)
    apart.add(BODIES[0], of=1, against=2)
    # Two fixed boxes are in all groups, the third in one.
    assert {2} == {max(pair) for pair in apart.pairs()}
    far = Scene()
    for of, against in [(1, 2), (1, 2), (2, 1)]:
        far.add(BODIES[1], of=of, against=against)
    assert {tuple(sorted(pair)) for pair in far.pairs()} == {(0, 2), (1, 2)}
    with pytest.raises(simdop.PoseError):
        scene.move(a, np.diag([1.0, 1.0, -1.0, 1.0]))
    with pytest.raises(simdop.SceneError):
        scene.collide(-1.0)


def test_clouds_are_obstacles() -> None:
    scene = Scene()
    scan = scene.add(Body.cloud([[0, 0, 0], [5, 0, 0]]), fixed=True)
    hand = scene.add(BODIES[2], at(2.5))
    assert not scene.collide()
    near = scene.clearance()
    assert float(near) == pytest.approx(2.1, abs=1e-6)
    scene.move(hand, at(4.8))
    assert {*scene.pairs()[0]} == {scan, hand}
