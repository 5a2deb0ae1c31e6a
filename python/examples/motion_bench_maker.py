"""Solve problems of MotionBenchMaker with OMPL and certified motions, and draw the last path.

    python motion_bench_maker.py panda.urdf panda.srdf mbm_panda.jsonl --every 100 --picture path.png

A line of the file is a problem: ``start``, ``goals`` and ``obstacles``, which are boxes and cylinders.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ompl import geometric, util

import simdop.ompl
from simdop import Body, PlanningScene, plot

Floats = NDArray[np.float64]


def pose(position: Sequence[float], quaternion: Sequence[float]) -> Floats:
    """The matrix of a position and a quaternion (x, y, z, w)."""
    x, y, z, w = np.asarray(quaternion) / np.linalg.norm(quaternion)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = position
    return matrix


def among_obstacles(robot: PlanningScene, problem: dict[str, Any]) -> PlanningScene:
    """The robot among the obstacles of a problem."""
    scene = robot.copy()
    for obstacle in problem["obstacles"]:
        dims = obstacle["dims"]
        # A cylinder's height comes before its radius.
        body = Body.box(dims) if obstacle["type"] == "box" else Body.cylinder(dims[1], dims[0])
        scene.add(obstacle["id"], body, pose(obstacle["pos"], obstacle["quat_xyzw"]))
    return scene


def ends(scene: PlanningScene, problem: dict[str, Any]) -> tuple[Floats, Floats]:
    """Start and goal. Variables that a goal leaves out keep their values."""
    start = dict(zip(scene.variables, np.clip(0.0, *scene.limits.T), strict=True)) | problem["start"]
    goal = start | problem["goals"][0]
    return np.array([start[name] for name in scene.variables]), np.array([goal[name] for name in scene.variables])


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each problem; return how many were not solved."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("urdf", type=Path)
    parser.add_argument("srdf", type=Path)
    parser.add_argument("problems", type=Path)
    parser.add_argument("--every", type=int, default=1, help="only each so many lines")
    parser.add_argument("--seconds", type=float, default=5.0, help="for each problem")
    parser.add_argument("--planner", default="RRTConnect", help="a class of ompl.geometric")
    parser.add_argument("--picture", type=Path, help="of the last path")
    options = parser.parse_args(arguments)
    util.setLogLevel(util.LOG_ERROR)
    robot = PlanningScene(options.urdf, options.srdf)
    lines = options.problems.read_text().splitlines()[:: options.every]
    times, last = [], None
    for problem in map(json.loads, lines):
        scene = among_obstacles(robot, problem)
        start, goal = ends(scene, problem)
        began = time.perf_counter()
        path = simdop.ompl.solve(
            scene, start, goal, planner=getattr(geometric, options.planner), seconds=options.seconds
        )
        spent = 1e3 * (time.perf_counter() - began)
        if path is None:
            print(f"{problem['set']} {problem['index']}: not solved in {spent:.0f} ms")
            continue
        times.append(spent)
        last = scene, path
        print(f"{problem['set']} {problem['index']}: {len(path)} configurations in {spent:.1f} ms")
    if times:
        print(f"{len(times)} of {len(lines)} solved, {statistics.median(times):.1f} ms each (median)")
    if options.picture and last is not None:
        plot.path(*last).figure.savefig(options.picture)
    return len(lines) - len(times)


if __name__ == "__main__":
    raise SystemExit(main())
