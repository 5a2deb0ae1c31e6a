"""``python -m simdop.bench``: simdop compared with the installed libraries, on the same bodies and poses.

Each row is one library: microseconds per pose, one call per pose and, where it takes arrays, one call for all; and how
many of its answers differ from simdop's. That count leaves out poses closer to contact than 1e-9.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import Body, RangeSearch, depths, isa
from ._arrays import Floats, Triangles
from .agreement import coal_model, compare, random_poses

Mesh = tuple[Floats, Triangles]


def _uneven(rows: int) -> Mesh:
    """A closed, uneven surface of about 2 rows^2 triangles about the origin."""
    u = np.pi * np.arange(1, rows) / rows
    v = 2 * np.pi * np.arange(rows) / rows
    radius = 1 + 0.15 * np.sin(5 * u)[:, None] * np.cos(4 * v)
    x, y, z = np.sin(u)[:, None] * np.cos(v), np.sin(u)[:, None] * np.sin(v), np.cos(u)[:, None] + 0 * v
    ring = np.stack([x, y, z], axis=2)
    points = np.concatenate([[[0, 0, 1.0]], (ring * radius[:, :, None]).reshape(-1, 3), [[0, 0, -1.0]]])
    faces, last = [], len(points) - 1

    def at(i: int, j: int) -> int:
        return 1 + i * rows + j % rows

    for j in range(rows):
        faces += [[0, at(0, j), at(0, j + 1)], [last, at(rows - 2, j + 1), at(rows - 2, j)]]
        for i in range(rows - 2):
            faces += [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    return points, np.array(faces)


def _poses(count: int) -> Floats:
    """Random poses at which bodies are about as often in contact as not."""
    return random_poses(count, 1.6, 2.3, 1)


def _time(
    work: Callable[[], Any], repeats: int = 5, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, Any]:
    """The median time of a call, in seconds, and its result."""
    times, result = [], None
    for _ in range(repeats):
        start = clock()
        result = work()
        times.append(clock() - start)
    return statistics.median(times), result


def _peers(mesh: Mesh) -> dict[str, tuple[Callable[[Floats], bool], Callable[[Floats], float]]]:
    """For each installed library: whether two such meshes meet at a pose, and how far they are apart."""
    vertices, faces = mesh
    peers: dict[str, tuple[Callable[[Floats], bool], Callable[[Floats], float]]] = {}
    try:
        fcl = importlib.import_module("fcl")
    except ImportError:
        pass
    else:
        model = fcl.BVHModel()
        model.beginModel(len(faces), len(vertices))
        model.addSubModel(vertices, faces)
        model.endModel()
        a, b = fcl.CollisionObject(model), fcl.CollisionObject(model)

        def fcl_collide(pose: Floats) -> bool:
            a.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
            return bool(fcl.collide(a, b))

        def fcl_distance(pose: Floats) -> float:
            a.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
            return float(fcl.distance(a, b))

        peers["python-fcl"] = fcl_collide, fcl_distance
    try:
        coal = importlib.import_module("coal")
    except ImportError:
        pass
    else:
        tree = coal_model(coal, mesh)
        still = coal.Transform3s()

        def coal_collide(pose: Floats) -> bool:
            at = coal.Transform3s(pose[:3, :3], pose[:3, 3])
            return bool(coal.collide(tree, at, tree, still, coal.CollisionRequest(), coal.CollisionResult()))

        def coal_distance(pose: Floats) -> float:
            at = coal.Transform3s(pose[:3, :3], pose[:3, 3])
            return float(coal.distance(tree, at, tree, still, coal.DistanceRequest(), coal.DistanceResult()))

        peers["coal"] = coal_collide, coal_distance
    return peers


def _row(name: str, one: float, many: float | None, wrong: str) -> None:
    print(f"| {name:12} | {one:9.2f} | {'' if many is None else f'{many:.2f}':>9} | {wrong:>5} |")


def meshes(rows: int, count: int) -> None:
    """Print the tables of verdicts and distances."""
    mesh, poses = _uneven(rows), _poses(count)
    body = Body(*mesh)
    truth, gaps = body.collide(body, poses), body.distance(body, poses).upper
    clear = (gaps == 0.0) | (gaps > 1e-9)
    print(f"\n{len(mesh[1])} triangles against a copy, {count} poses, {int(np.sum(truth))} in contact; us a pose\n")
    print("| verdict      | one by one | in arrays | wrong |\n|---|--:|--:|--:|")
    one, _ = _time(lambda: [body.collide(body, pose) for pose in poses])
    many, _ = _time(lambda: body.collide(body, poses))
    call = _time(lambda: [Body.collide(far, far, apart) for _ in range(1000)])[0] / 1000 * 1e6
    _row("simdop", one / count * 1e6, many / count * 1e6, "0")
    peers = _peers(mesh)
    for name, (collide, _) in peers.items():
        spent, found = _time(lambda collide=collide: [collide(pose) for pose in poses], 3)  # type: ignore[misc]
        _row(name, spent / count * 1e6, None, str(int(np.sum((np.array(found) != truth) & clear))))
    print("\n| distance     | one by one | in arrays | wrong |\n|---|--:|--:|--:|")
    one, _ = _time(lambda: [body.distance(body, pose) for pose in poses], 3)
    many, _ = _time(lambda: body.distance(body, poses), 3)
    _row("simdop", one / count * 1e6, many / count * 1e6, "0")
    for name, (_, distance) in peers.items():
        spent, found = _time(lambda distance=distance: [distance(pose) for pose in poses], 1)  # type: ignore[misc]
        off = np.abs(np.maximum(np.array(found), 0.0) - gaps) > 1e-6
        _row(name, spent / count * 1e6, None, str(int(np.sum(off & clear))))
    print(f"\nA call of simdop that finds two distant bodies free takes {call:.2f} us, nearly all of it Python's.")


far, apart = Body.spheres([[0.0, 0.0, 0.0]], 1.0), np.eye(4)
apart[0, 3] = 100.0


def points(count: int) -> None:
    """Print the table of neighbours."""
    cloud = np.random.default_rng(2).uniform(size=(count, 3)).astype(np.float32)
    radius = float((30 / count / (4 / 3 * np.pi)) ** (1 / 3))
    search = RangeSearch(cloud)
    spent, (offsets, _) = _time(lambda: search.neighbours(radius))
    near, _ = _time(lambda: search.nearest(cloud, 8), 3)
    print(f"\n{count} points, {offsets[-1] / count:.0f} neighbours each; ms\n")
    print("| all points     | within a radius | 8 nearest |\n|---|--:|--:|")
    print(f"| simdop         | {spent * 1e3:15.1f} | {near * 1e3:9.1f} |")
    try:
        tree = importlib.import_module("scipy.spatial").cKDTree(cloud)
    except ImportError:
        return
    spent, _ = _time(lambda: tree.query_ball_point(cloud, radius), 3)
    near, _ = _time(lambda: tree.query(cloud, 8), 3)
    print(f"| SciPy cKDTree  | {spent * 1e3:15.1f} | {near * 1e3:9.1f} |")


class _Queries:
    """Verdicts by the C library, ``libsimdop_capi.so``: the cost of an array of poses without Python."""

    def __init__(self, path: str, body: Body) -> None:
        self._library = ctypes.CDLL(path)
        data = np.frombuffer(body.to_bytes(), np.uint8)
        room = np.empty(len(data) + 64, np.uint8)
        # Trees are aligned to 64 bytes.
        self._bytes = room[-room.ctypes.data % 64 :][: len(data)]
        self._bytes[:] = data
        self._body = ctypes.c_void_p()
        first, count = ctypes.c_void_p(self._bytes.ctypes.data), ctypes.c_size_t(len(data))
        code = self._library.simdop_body_open(first, count, ctypes.byref(self._body))
        if code != 0:
            raise OSError(f"{path} cannot open the tree: error {code}")

    def collide(self, poses: Floats) -> NDArray[np.bool_]:
        """Whether the mesh meets a copy of itself at each of n poses, (n, 3, 4)."""
        # The verdict is the first of 72 bytes.
        answers = np.empty((len(poses), 72), np.uint8)
        no_budget = ctypes.c_uint64(2**64 - 1)
        arrays = ctypes.c_void_p(poses.ctypes.data), ctypes.c_void_p(answers.ctypes.data)
        code = self._library.simdop_collide_at_poses(
            self._body, self._body, arrays[0], ctypes.c_size_t(len(poses)), no_budget, arrays[1]
        )
        if code != 0:
            raise OSError(f"the poses cannot be tested: error {code}")
        return np.equal(answers[:, 0], 1)


def _import_time() -> float:
    """Seconds that ``import simdop`` takes after numpy, in a new interpreter: the least of five."""
    program = "import numpy, time; t = time.perf_counter(); import simdop; print(time.perf_counter() - t)"
    runs = [subprocess.run([sys.executable, "-c", program], capture_output=True, check=True) for _ in range(5)]
    return min(float(run.stdout) for run in runs)


def interpreter(rows: int, count: int, library: str) -> None:
    """Print what Python adds: to a call, to an array of poses, and to the start of a program.

    Times of queries are CPU times, since the machine may be busy.
    """
    mesh, poses = _uneven(rows), _poses(count)
    body = Body(*mesh)
    queries = _Queries(library, body)
    matrices = np.ascontiguousarray(poses[:, :3, :])
    ratios, arrays, calls = [], [], []
    for _ in range(15):
        spent_c, found_c = _time(lambda: queries.collide(matrices), 1, time.process_time)
        spent, found = _time(lambda: body.collide(body, poses), 1, time.process_time)
        spent_each, _ = _time(lambda: [body.collide(body, pose) for pose in poses], 1, time.process_time)
        if not (found == found_c).all():
            raise AssertionError("verdicts of Python and C differ")
        ratios.append(spent / spent_c)
        arrays.append((spent - spent_c) / count * 1e6)
        calls.append((spent_each - spent_c) / count * 1e6)
    ratio, more, call = map(statistics.median, (ratios, arrays, calls))
    print(f"\n{count} poses of {len(mesh[1])} triangles, beside C: an array takes {ratio:.3f} times as long,")
    print(f"{more:.3f} us more a pose; calls one by one {call:.2f} us more each.")
    print(f"import simdop, after numpy: {_import_time() * 1e3:.1f} ms")


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m simdop.bench", description=__doc__)
    parser.add_argument("--rows", type=int, default=40, help="the mesh has about 2 rows^2 triangles")
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--points", type=int, default=20_000)
    parser.add_argument("--library", help="libsimdop_capi.so: only what Python adds to the same queries in C")
    parser.add_argument("--agree", type=int, metavar="POSES", help="only compare answers of five meshes with Coal's")
    parser.add_argument("--depth", type=Path, nargs="+", metavar="MESH", help="only compare depths of closed meshes")
    options = parser.parse_args()
    print(f"simdop on {isa}")
    if options.agree:
        sys.exit(1 if compare(options.agree) else 0)
    if options.depth:
        sys.exit(1 if depths.compare(options.depth, options.poses) else 0)
    if options.library:
        interpreter(options.rows, options.poses, options.library)
        return
    meshes(options.rows, options.poses)
    points(options.points)


if __name__ == "__main__":
    main()
