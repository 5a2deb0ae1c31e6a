"""Threads that share one object: the answers are those of one thread.

`.ci/sweep memory` runs this file under the thread sanitizer.
"""

from __future__ import annotations

import faulthandler
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapes import at, ball, box, poses
from simdop import Body, PlanningScene, RangeSearch, Scene
from test_planning import SRDF, URDF

ROUNDS = 12
# More threads than cores, so that threads are interrupted in the middle of calls.
THREADS = 4


@pytest.fixture(autouse=True)
def limit() -> Iterator[None]:
    """Switches threads often, and ends the program if they deadlock: then none could raise an exception."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    faulthandler.dump_traceback_later(600.0, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()
    sys.setswitchinterval(interval)


def together(*works: Callable[[], None]) -> None:
    """Runs all at once, and raises the exception of any of them."""
    barrier, errors = threading.Barrier(len(works)), []

    def run(work: Callable[[], None]) -> None:
        try:
            barrier.wait()
            work()
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=run, args=(work,)) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


def same(one: list[Any], other: list[Any]) -> bool:
    """Whether all values and arrays are equal, bit for bit."""
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def agree(ask: Callable[[], list[Any]]) -> None:
    """Several threads give the answers of this one."""
    expected = ask()

    def work() -> None:
        for _ in range(ROUNDS):
            assert same(ask(), expected)

    together(*[work] * THREADS)
    assert same(ask(), expected)


def agree_while(change: Callable[[int], object], ask: Callable[[], Any]) -> None:
    """While one thread switches between state 0 and state 1, each answer of the others belongs to one of them."""
    expected: list[list[Any]] = []
    for state in (1, 0):
        change(state)
        expected.insert(0, [ask()])
    assert not same(*expected)

    asking = [True] * (THREADS - 1)

    def work() -> None:
        try:
            for _ in range(ROUNDS):
                answer = [ask()]
                assert same(answer, expected[0]) or same(answer, expected[1])
        finally:
            asking.pop()

    def flip() -> None:
        state = 0
        while asking:
            state = 1 - state
            change(state)

    together(flip, *[work] * (THREADS - 1))
    change(0)
    assert same([ask()], expected[0])


@pytest.mark.parametrize("solid", [False, True])
@pytest.mark.parametrize("inner", [1, 2])
def test_threads_share_a_body(solid: bool, inner: int, rng: np.random.Generator) -> None:
    a, b = Body(*box(0.8, 0.9, 1.0), solid=solid), Body(*ball(1, 0.05), solid=solid)
    many, one = poses(rng, 60, 3.0), at(0.7)

    def ask() -> list[Any]:
        found, depth, signed = a.distance(b, many, threads=inner), a.depth(b, one), a.signed_distance(b, one)
        contacts = a.contacts(b, one)
        return [
            *(found.lower, found.upper, found.point_a, found.point_b, found.index_a, found.index_b),
            *(a.collide(b, many, threads=inner), a.within(b, 0.3, many, threads=inner)),
            *(contacts.index_a, contacts.index_b, contacts.points, contacts.depths),
            *(depth.lower, depth.translation, signed.lower, signed.gradient),
        ]

    agree(ask)


def test_threads_share_other_kinds_of_bodies(rng: np.random.Generator) -> None:
    cloud, hull = Body.cloud(rng.uniform(-1, 1, size=(300, 3))), Body.hull(rng.uniform(-0.4, 0.4, size=(40, 3)))
    shapes, many = Body.shapes([Body.box([1, 1, 1]), Body.sphere(0.4, at=at(1.0))]), poses(rng, 40, 2.0)
    packed = Body(*box()).pack(100)

    def ask() -> list[Any]:
        near, shared = hull.distance(cloud, many, threads=2), packed.penetration(packed, at(0.3))
        return [
            *(near.upper, near.index_b, hull.collide(shapes, many), shapes.within(cloud, 0.1, many)),
            *(shared.volume, shared.direction, packed.to_bytes() == Body.from_bytes(packed.to_bytes()).to_bytes()),
            *(hull.vertices, Body(*box()).cover(0.1).radii),
        ]

    agree(ask)


def filled(rng: np.random.Generator) -> tuple[Scene, list[int]]:
    """A scene of bodies at random poses, and their numbers."""
    bodies = [Body(*box(), solid=True), Body(*ball(1)), Body.sphere(0.4), Body.capsule(0.2, 0.8)]
    scene = Scene()
    return scene, [scene.add(bodies[i % 4], pose) for i, pose in enumerate(poses(rng, 12, 4.0))]


def test_threads_share_a_scene(rng: np.random.Generator) -> None:
    scene, numbers = filled(rng)
    other, _ = filled(rng)

    def ask() -> list[Any]:
        near, deep = scene.clearance(other=other), scene.signed_clearance()
        return [
            *(scene.collide(), scene.pairs(0.5), scene.pairs(other=other), scene.collide(other=scene)),
            *(near.upper, near.bodies, deep.lower, deep.bodies, scene.copy().pairs(), scene.pose(numbers[0])),
        ]

    agree(ask)


def test_a_scene_changes_while_threads_ask(rng: np.random.Generator) -> None:
    scene, numbers = filled(rng)
    places = [at(0.0), at(1.0, 0.5)]
    agree_while(lambda state: scene.move(numbers[0], places[state]), lambda: scene.pairs(0.2))
    agree_while(lambda state: scene.move(numbers[0], places[state]), lambda: float(scene.pose(numbers[0])[0, 3]))
    pair = (numbers[0], numbers[4])
    scene.move(numbers[4], at(0.1))
    agree_while(
        lambda state: scene.allow_collision(*pair) if state else scene.forbid_collision(*pair), lambda: scene.pairs()
    )


@pytest.fixture
def planning(tmp_path: Path) -> PlanningScene:
    """A robot beside a post, whose number is looked up by its name."""
    urdf, srdf = tmp_path / "two.urdf", tmp_path / "two.srdf"
    urdf.write_text(URDF)
    srdf.write_text(SRDF)
    scene = PlanningScene(urdf, srdf)
    scene.add("post", Body.cylinder(0.4, 1.0), at(1.2, 0.8))
    return scene


@pytest.mark.parametrize("bounds", [False, True])
def test_threads_share_a_planning_scene(bounds: bool, planning: PlanningScene, rng: np.random.Generator) -> None:
    if bounds:
        planning.use_bounds(0.05)
    many, ends = rng.uniform(-3, 3, size=(60, 2)), rng.uniform(-3, 3, size=(60, 2))
    free, points = many[planning.free(many)], rng.uniform(-2, 2, size=(200, 3))

    def ask() -> list[Any]:
        near, (values, gradients) = planning.clearance(many[0]), planning.signed_clearances(many, threads=2)
        return [
            *(planning.free(many), planning.free(many, margin=0.1, threads=2), planning.is_free(many[1])),
            *(planning.free_edges(many, ends, threads=2), planning.edge_is_free(many[2], ends[2])),
            *(near.upper, near.gradient, values, gradients, planning.free_share(many[3], ends[3])),
            *(planning.plan(free[0], free[1], configurations=200, shortcuts=5), planning.hits(many[0]) == []),
            *(planning.near_robot(many[0], points), planning.copy().free(many[:20])),
        ]

    agree(ask)


def test_a_planning_scene_changes_while_threads_ask(planning: PlanningScene, rng: np.random.Generator) -> None:
    post, places = planning.objects["post"], [at(1.2, 0.8), at(-1.0, -0.5)]
    many, ends = rng.uniform(-3, 3, size=(40, 2)), rng.uniform(-3, 3, size=(40, 2))
    agree_while(lambda state: planning.move(post, places[state]), lambda: planning.free(many, threads=2))
    agree_while(lambda state: planning.move(post, places[state]), lambda: planning.free_edges(many, ends))
    planning.use_bounds(0.1)
    agree_while(lambda state: planning.move(post, places[state]), lambda: planning.free(many, threads=2))


def test_arguments_may_ask_and_change_the_scene_that_they_are_for(planning: PlanningScene) -> None:
    post = planning.objects["post"]

    class Moving:
        """An array that moves the post whenever it is read."""

        def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
            planning.move(post, at(9.0))
            return np.zeros((3, 2))

    places: Any = Moving()
    assert planning.free(places).tolist() == [True] * 3
    assert planning.free_edges(places, places).tolist() == [True] * 3
    assert (planning.signed_clearances(places)[0] > 5.0).all()


def test_threads_share_a_cloud(rng: np.random.Generator) -> None:
    search, queries = RangeSearch(rng.uniform(-1, 1, size=(500, 3))), rng.uniform(-1, 1, size=(60, 3))

    def ask() -> list[Any]:
        return [
            *search.neighbours(0.3),
            *search.neighbours(0.3, queries),
            *search.nearest(queries, 5, threads=2),
            search.any_within(0.1, queries, threads=2),
        ]

    agree(ask)


def test_a_cloud_changes_while_threads_ask(rng: np.random.Generator) -> None:
    points = [rng.uniform(-1, 1, size=(300, 3)) for _ in range(2)]
    search, queries = RangeSearch(points[0]), rng.uniform(-1, 1, size=(40, 3))

    def change(state: int) -> None:
        search.refit(points[state])
        search.rebuild()

    agree_while(change, lambda: np.hstack(search.nearest(queries, 4, threads=2)))
    agree_while(lambda state: search.refit(points[state]), lambda: np.hstack(search.neighbours(0.3, queries)))


def test_the_interpreter_runs_on_during_a_query(rng: np.random.Generator) -> None:
    a, b, many = Body(*ball(2, 0.05)), Body(*ball(2, 0.03)), poses(rng, 2000, 3.0)
    interval, ended, seen = sys.getswitchinterval(), threading.Event(), False

    def work() -> None:
        a.distance(b, many)
        ended.set()

    # This thread runs only where the other releases the lock by itself.
    sys.setswitchinterval(1000.0)
    try:
        for _ in range(10):
            ended.clear()
            thread = threading.Thread(target=work)
            thread.start()
            seen = not ended.is_set()
            thread.join()
            if seen:
                break
    finally:
        sys.setswitchinterval(interval)
    assert seen
