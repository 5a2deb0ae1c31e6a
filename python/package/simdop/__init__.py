"""Exact collision and distance queries between meshes, shapes, spheres and point clouds.

A ``Body`` is a mesh, shapes, spheres or points, with a tree over them. A pose is a 4 x 4 matrix that places body A in
the frame of body B; queries take an array of n poses, (n, 4, 4), in one call, without the interpreter's lock. ``Scene``
holds many bodies at poses in the world, and ``RangeSearch`` finds neighbours among points.

``simdop.plot`` and ``simdop.view`` show bodies, scenes and paths, and ``simdop.ompl`` plans with OMPL.
``simdop.trimesh`` replaces trimesh's ``CollisionManager``, and ``simdop.fcl`` the module of python-fcl.
"""

from ._simdop import (
    ArrayError,
    Body,
    BodyError,
    BuildError,
    Clearance,
    CloudError,
    Contacts,
    CoverError,
    Depth,
    Distance,
    Error,
    FileError,
    FormatError,
    PackError,
    Patch,
    Penetration,
    PlanningError,
    PlanningScene,
    PoseError,
    RangeSearch,
    Scene,
    SceneError,
    ShapeError,
    SignedClearance,
    SignedDistance,
    ToleranceError,
    __version__,
    isa,
)

__all__ = [
    "ArrayError",
    "Body",
    "BodyError",
    "BuildError",
    "Clearance",
    "CloudError",
    "Contacts",
    "CoverError",
    "Depth",
    "Distance",
    "Error",
    "FileError",
    "FormatError",
    "PackError",
    "Patch",
    "Penetration",
    "PlanningError",
    "PlanningScene",
    "PoseError",
    "RangeSearch",
    "Scene",
    "SceneError",
    "ShapeError",
    "SignedClearance",
    "SignedDistance",
    "ToleranceError",
    "__version__",
    "isa",
]
