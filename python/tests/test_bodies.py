"""Bodies: their contents, and how they are stored."""

from __future__ import annotations

import pickle
import struct
from pathlib import Path

import numpy as np
import pytest

import simdop
from shapes import at, ball, box, poses
from simdop import Body

SHAPES = {
    "sphere": Body.sphere(0.3),
    "capsule": Body.capsule(0.2, 0.7),
    "box": Body.box([1, 2, 3], radius=0.1, at=at(0.1, 0.2, 0.3)),
    "cylinder": Body.cylinder(0.5, 0.7),
    "cone": Body.cone(0.5, 0.7),
    "triangle": Body.triangle([[0, 0, 0], [1, 0, 0], [0, 1, 0]]),
    "half-space": Body.half_space([1, 2, 3], 0.7),
}
TREES = {
    "mesh": Body(*ball(1), solid=True),
    "spheres": Body.spheres([[0, 0, 0], [1, 0, 0]], [0.5, 0.25]),
    "shapes": Body.shapes([SHAPES["capsule"], SHAPES["box"]]),
    "cloud": Body.cloud([[0, 0, 0], [1, 2, 3]]),
}


def same(a: Body, b: Body) -> bool:
    """Whether two bodies are equal, by their text and bytes."""
    bytes_of = [body.to_bytes() if body.nbytes else b"" for body in (a, b)]
    return a.kind == b.kind and repr(a) == repr(b) and bytes_of[0] == bytes_of[1]


@pytest.mark.parametrize("kind", SHAPES | TREES)
def test_bodies_have_kinds_and_survive_pickle(kind: str) -> None:
    body = (SHAPES | TREES)[kind]
    assert body.kind == kind
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        assert same(pickle.loads(pickle.dumps(body, protocol)), body)


@pytest.mark.parametrize("kind", TREES)
def test_trees_are_files(kind: str, tmp_path: Path) -> None:
    body, path = TREES[kind], tmp_path / "body.simdop"
    body.save(path)
    assert path.read_bytes() == body.to_bytes()
    assert body.nbytes == len(body.to_bytes())
    assert same(Body.load(path), body)
    assert same(Body.from_bytes(body.to_bytes()), body)


def test_one_shape_has_no_file() -> None:
    with pytest.raises(simdop.BodyError, match=r"Body\.shapes"):
        SHAPES["box"].to_bytes()
    assert SHAPES["box"].nbytes == 0


@pytest.mark.parametrize("kind", TREES)
def test_damaged_bytes_are_refused_or_safe(kind: str, rng: np.random.Generator) -> None:
    whole = TREES[kind].to_bytes()
    for length in (0, 7, 64, 127, len(whole) - 64, len(whole) - 1):
        with pytest.raises(simdop.FormatError):
            Body.from_bytes(whole[:length])
    with pytest.raises(simdop.FormatError):
        Body.from_bytes(whole + bytes(64))
    refused = 0
    for _ in range(300):
        damaged = bytearray(whole)
        damaged[rng.integers(len(whole))] ^= 1 << rng.integers(8)
        try:
            body = Body.from_bytes(bytes(damaged))
        except simdop.FormatError:
            refused += 1
            continue
        Body.sphere(0.3).collide(body)
        Body.sphere(0.3).distance(body)
    assert refused > 30


def test_files_of_meshes(tmp_path: Path) -> None:
    vertices, faces = box()
    stl = tmp_path / "box.stl"
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *vertices[face].ravel(), 0) for face in faces)
    stl.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + records)
    body = Body.load(stl, solid=True)
    assert same(body, Body(vertices, faces, solid=True)) or len(body) == 12
    assert body.vertices[body.faces].tolist() == vertices[faces].tolist()
    with pytest.raises(FileNotFoundError):
        Body.load(tmp_path / "none.stl")
    (tmp_path / "bad.obj").write_text("v 0 0 zero\n")
    with pytest.raises(simdop.FileError, match="line 1: 'zero' is not a number"):
        Body.load(tmp_path / "bad.obj")
    (tmp_path / "scan.xyz").write_text("0 0 0\n1 2 3\n")
    assert len(Body.load_cloud(tmp_path / "scan.xyz")) == 2


def test_arrays_come_back_in_order(rng: np.random.Generator) -> None:
    vertices, faces = ball(2, 0.05)
    body = Body(vertices, faces)
    assert body.vertices[body.faces].tolist() == vertices[faces].tolist()
    centres, radii = rng.normal(size=(100, 3)), rng.uniform(0.1, 1.0, 100)
    spheres = Body.spheres(centres, radii)
    assert spheres.centres.tolist() == centres.tolist()
    assert spheres.radii.tolist() == radii.tolist()
    with pytest.raises(simdop.BodyError, match="takes a mesh, not a body of kind 'spheres'"):
        spheres.faces  # noqa: B018


def test_solids_must_be_closed() -> None:
    vertices, faces = box()
    with pytest.raises(simdop.BuildError):
        Body(vertices, faces[:-1], solid=True)
    capped = Body(vertices, faces[:-1], caps=2.0)
    assert capped.is_solid
    assert capped.caps[:2] == (1, 1)
    assert Body.sphere(0.1).collide(capped)
    assert not Body.sphere(0.1).collide(Body(vertices, faces))
    with pytest.raises(simdop.BuildError, match="'slow'"):
        Body(vertices, faces, build="slow")  # type: ignore[arg-type]


@pytest.mark.parametrize("build", ["best", "balanced", "fast"])
def test_all_builds_give_the_same_verdicts(build: str, rng: np.random.Generator) -> None:
    mesh, at_poses = ball(2, 0.05), poses(rng, 200, 3.0)
    expected = Body(*mesh).collide(Body(*mesh), at_poses)
    built = Body(*mesh, build=build)  # type: ignore[arg-type]
    assert (built.collide(built, at_poses) == expected).all()


def test_packed_spheres_are_inside_and_disjoint() -> None:
    packed = Body(*box(1, 1, 2)).pack(50)
    centres, radii = packed.centres, packed.radii
    assert 20 <= len(packed) <= 50
    assert (np.abs(centres) + radii[:, None] <= np.array([0.5, 0.5, 1.0]) + 1e-12).all()
    gaps = np.linalg.norm(centres[:, None] - centres, axis=2) - radii[:, None] - radii
    assert gaps[~np.eye(len(packed), dtype=bool)].min() >= -1e-12
    with pytest.raises(simdop.PackError):
        Body(*box()[:1], box()[1][1:]).pack(5)


def test_covers_contain_the_mesh(rng: np.random.Generator) -> None:
    body = Body(*box(), solid=True)
    inside = rng.uniform(-0.5, 0.5, size=(2000, 3))
    on_top = np.where(np.arange(3) == 2, 0.5, inside)
    for cover, points in [(body.cover(0.2), inside), (body.cover(0.2, solid=False), on_top)]:
        gaps = np.linalg.norm(points[:, None] - cover.centres, axis=2) - cover.radii
        assert gaps.min(axis=1).max() <= 1e-9
        # A point of a sphere is outside by at most the error.
        outside = np.maximum(np.abs(cover.centres) - 0.5, 0.0)
        assert (np.linalg.norm(outside, axis=1) + cover.radii).max() <= 1.0
    with pytest.raises(simdop.CoverError):
        body.cover(0.0)


def test_numbers_of_shapes_are_checked() -> None:
    with pytest.raises(simdop.ShapeError):
        Body.sphere(-1.0)
    with pytest.raises(simdop.ShapeError):
        Body.box([1, 0, 1])
    with pytest.raises(simdop.ShapeError):
        Body.half_space([0, 0, 0])
    with pytest.raises(simdop.ArrayError, match=r"\(3,\)"):
        Body.box([1, 2])
    with pytest.raises(simdop.ArrayError, match=r"\(3, 3\)"):
        Body.triangle([[0, 0, 0], [1, 0, 0]])
    with pytest.raises(simdop.ShapeError):
        Body.shapes([SHAPES["half-space"]])
    with pytest.raises(simdop.ArrayError, match="2 centres and 3 radii"):
        Body.spheres([[0, 0, 0], [1, 0, 0]], [1, 1, 1])
    assert len(Body.shapes([])) == 0


def test_texts_help() -> None:
    assert repr(TREES["mesh"]) == "Body(mesh, 32 triangles, solid)"
    assert repr(TREES["cloud"]) == "Body(cloud, 2 primitives)"
    assert "Cuboid" in repr(SHAPES["box"])
    assert issubclass(simdop.BuildError, simdop.Error)
    assert issubclass(simdop.Error, ValueError)
