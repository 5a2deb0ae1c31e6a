"""Range search, against loops over all points."""

from __future__ import annotations

import numpy as np
import pytest

import oracle
import simdop
from simdop import RangeSearch


@pytest.mark.parametrize("count", [0, 1, 16, 17, 500])
@pytest.mark.parametrize("radius", [0.0, 0.1, 0.4, 9.0])
def test_neighbours_are_those_of_a_loop(count: int, radius: float, rng: np.random.Generator) -> None:
    points = rng.uniform(-1, 1, size=(count, 3)).astype(np.float32)
    search, queries = RangeSearch(points), rng.uniform(-1, 1, size=(40, 3)).astype(np.float32)
    for asked, result in [(queries, search.neighbours(radius, queries)), (points, search.neighbours(radius))]:
        offsets, indices = result
        assert offsets.shape == (len(asked) + 1,)
        assert offsets[0] == 0
        assert offsets[-1] == len(indices)
        for i, query in enumerate(asked):
            found = indices[offsets[i] : offsets[i + 1]]
            assert sorted(found.tolist()) == oracle.neighbours(points, query, radius)
    expected = [len(oracle.neighbours(points, query, radius)) > 0 for query in queries]
    assert search.any_within(radius, queries, threads=2).tolist() == expected


@pytest.mark.parametrize("k", [0, 1, 5, 40])
def test_nearest_points_are_those_of_a_loop(k: int, rng: np.random.Generator) -> None:
    points = rng.integers(-3, 3, size=(30, 3)).astype(np.float32)
    queries = rng.integers(-3, 3, size=(50, 3)).astype(np.float32)
    distances, indices = RangeSearch(points).nearest(queries, k, threads=2)
    assert distances.shape == indices.shape == (50, k)
    for i, query in enumerate(queries):
        expected = oracle.nearest(points, query, k)
        assert indices[i, : len(expected)].tolist() == expected
        assert distances[i, : len(expected)] == pytest.approx(np.linalg.norm(points[expected] - query, axis=1))
        assert (indices[i, 30:] == -1).all()
        assert np.isinf(distances[i, 30:]).all()


def test_points_move(rng: np.random.Generator) -> None:
    points = rng.uniform(-1, 1, size=(300, 3)).astype(np.float32)
    search = RangeSearch(points)
    for step in range(5):
        points = points + rng.normal(scale=0.1, size=points.shape).astype(np.float32)
        assert search.refit(points) > 0.0
        if step == 3:
            search.rebuild()
        offsets, indices = search.neighbours(0.3)
        for i, query in enumerate(points):
            assert sorted(indices[offsets[i] : offsets[i + 1]].tolist()) == oracle.neighbours(points, query, 0.3)
    assert len(search) == 300
    assert repr(search) == "RangeSearch(300 points)"


def test_bad_input_is_refused(rng: np.random.Generator) -> None:
    points = rng.uniform(size=(20, 3))
    search = RangeSearch(points)
    for radius in (-1.0, np.nan, np.inf):
        with pytest.raises(simdop.CloudError):
            search.neighbours(radius)
    bad = points.copy()
    bad[7, 2] = np.nan
    for ask in (lambda: RangeSearch(bad), lambda: search.neighbours(0.1, bad), lambda: search.nearest(bad)):
        with pytest.raises(simdop.CloudError):
            ask()
    with pytest.raises(simdop.CloudError):
        search.refit(points[:5])
    with pytest.raises(MemoryError):
        search.nearest(points, 2**62)
    offsets, indices = search.neighbours(0.1, np.zeros((0, 3)))
    assert offsets.tolist() == [0]
    assert len(indices) == 0
