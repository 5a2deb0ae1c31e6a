"""Any array is converted, or refused with a typed error: never a crash."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import simdop
from shapes import at, box
from simdop import Body

VERTICES, FACES = box()


def misaligned(array: NDArray[Any]) -> NDArray[Any]:
    """A copy that starts one byte beyond an aligned address."""
    memory = np.zeros(array.nbytes + 1, np.uint8)
    view = memory[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    assert not view.flags.aligned
    return view


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A copy that cannot be written to."""
    copy = array.copy()
    copy.flags.writeable = False
    return copy


def strided(array: NDArray[Any]) -> NDArray[Any]:
    """Every second row of an array whose other rows hold other values."""
    table = np.full((2 * len(array), *array.shape[1:]), 77).astype(array.dtype)
    table[::2] = array
    return table[::2]


LAYOUTS: dict[str, Callable[[Any], Any]] = {
    "fortran": np.asfortranarray,
    "reversed twice": lambda array: array[::-1].copy()[::-1],
    "strided": strided,
    "misaligned": misaligned,
    "read-only": read_only,
    "big-endian": lambda array: array.astype(array.dtype.newbyteorder(">")),
    "list": lambda array: array.tolist(),
    "tuple of rows": lambda array: tuple(map(tuple, array.tolist())),
    "subclass": lambda array: array.view(type("Tracked", (np.ndarray,), {})),
    "objects of numbers": lambda array: array.astype(object).tolist(),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_gives_the_same_body(layout: str) -> None:
    change, expected = LAYOUTS[layout], Body(VERTICES, FACES, solid=True).to_bytes()
    assert Body(change(VERTICES), FACES, solid=True).to_bytes() == expected
    assert Body(VERTICES, change(FACES), solid=True).to_bytes() == expected


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_gives_the_same_poses(layout: str) -> None:
    body, change = Body(VERTICES, FACES), LAYOUTS[layout]
    poses = np.stack([at(0.5), at(1.0), at(1.5)])
    assert body.collide(body, change(poses)).tolist() == [True, True, False]
    assert body.collide(body, change(at(1.5))) is False


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", "f16", "i1", "i8", "u1", "?"])
def test_numbers_of_any_type_are_vertices(dtype: str) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert Body(corners.astype(dtype), [[0, 1, 2]]).vertices.tolist() == corners.tolist()


@pytest.mark.parametrize("dtype", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"])
def test_integers_of_any_type_are_triangles(dtype: str) -> None:
    assert len(Body(VERTICES, FACES.astype(dtype))) == 12


@pytest.mark.parametrize(
    "vertices",
    [VERTICES.astype(complex), VERTICES.astype(str), VERTICES.astype(object), np.zeros((8, 3), "M8[s]"), None, "text"],
    ids=["complex", "text", "objects", "dates", "none", "word"],
)
def test_what_is_no_number_is_a_type_error(vertices: Any) -> None:
    with pytest.raises(TypeError, match="vertices must be numbers"):
        Body(vertices, FACES)
    body = Body(VERTICES, FACES)
    with pytest.raises(TypeError, match="pose must be numbers"):
        body.collide(body, "identity")


def test_indices_are_integers_in_range() -> None:
    with pytest.raises(TypeError, match="triangles must be integers"):
        Body(VERTICES, FACES.astype(float))
    for index in (-1, 2**32, 2**62):
        with pytest.raises(simdop.ArrayError, match=f"not {index}"):
            Body(VERTICES, [[0, 1, index]])
    with pytest.raises(simdop.ArrayError, match="indices"):
        Body(VERTICES, np.array([[0, 1, 2**64 - 1]], np.uint64))
    with pytest.raises(simdop.BuildError, match="primitive 0 names a vertex that there is not"):
        Body(VERTICES, [[0, 1, 8]])


@pytest.mark.parametrize("shape", [(8,), (8, 2), (8, 4), (2, 4, 3), (), (0, 2)])
def test_shapes_are_checked(shape: tuple[int, ...]) -> None:
    with pytest.raises(simdop.ArrayError, match=r"must have the shape \(n, 3\)"):
        Body(np.zeros(shape), FACES)
    with pytest.raises(simdop.ArrayError, match=r"must have the shape \(n, 3\)"):
        Body(VERTICES, np.zeros(shape, int))
    body = Body(VERTICES, FACES)
    with pytest.raises(simdop.ArrayError, match=r"\(4, 4\) or \(n, 4, 4\)"):
        body.collide(body, np.zeros(shape))
    with pytest.raises(simdop.ArrayError, match=r"must have the shape \(n, 3\)"):
        simdop.RangeSearch(np.zeros(shape))


def test_ragged_rows_are_refused() -> None:
    with pytest.raises(ValueError, match="inhomogeneous"):
        Body([[0, 0, 0], [1, 0]], FACES)


@pytest.mark.parametrize("empty", [[], np.zeros((0, 3)), np.zeros((0, 3), int)])
def test_without_triangles_a_body_is_empty(empty: Any) -> None:
    body, other = Body(VERTICES, empty), Body(VERTICES, FACES)
    assert len(body) == 0
    assert body
    assert not body.collide(other)
    assert body.distance(other).lower == np.inf
    assert other.collide(other, np.zeros((0, 4, 4))).shape == (0,)
    assert other.distance(other, []).point_a.shape == (0, 3)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_what_is_not_finite_is_refused(bad: float) -> None:
    vertices = VERTICES.copy()
    vertices[5, 1] = bad
    with pytest.raises(simdop.BuildError):
        Body(vertices, FACES)
    body, poses = Body(VERTICES, FACES), np.stack([at(0.0), at(1.0)])
    poses[1, 2, 3] = bad
    with pytest.raises(simdop.PoseError, match=r"^pose\[1\]: "):
        body.collide(body, poses)
    with pytest.raises(simdop.ToleranceError):
        body.within(body, bad if bad != 1e200 else -1.0)


def test_poses_are_rigid() -> None:
    body = Body(VERTICES, FACES)
    with pytest.raises(simdop.PoseError, match="mirrors"):
        body.collide(body, np.diag([-1.0, 1.0, 1.0, 1.0]))
    with pytest.raises(simdop.PoseError, match="rigid"):
        body.collide(body, np.diag([2.0, 1.0, 1.0, 1.0]))
    projective = np.eye(4)
    projective[3, 0] = 1e-3
    with pytest.raises(simdop.PoseError, match="last row"):
        body.collide(body, projective)


def test_arrays_are_copied() -> None:
    vertices, faces = VERTICES.copy(), FACES.astype(np.uint32)
    body = Body(vertices, faces)
    before = body.to_bytes()
    vertices[...], faces[...] = 9.0, 0
    assert body.to_bytes() == before


def test_results_own_their_memory() -> None:
    body = Body(VERTICES, FACES)
    verdicts = body.collide(body, np.stack([at(0.5)] * 1000))
    del body
    assert isinstance(verdicts, np.ndarray)
    assert verdicts.flags.owndata or verdicts.base is not None
    assert verdicts.dtype == bool
    verdicts[...] = False
