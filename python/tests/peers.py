"""Run the tests of python-fcl and trimesh against the drop-ins: ``python peers.py FILE...``.

``FILE`` is a test file of either, in its original folder: trimesh's need ``generic.py`` beside them, and ``../models``.
Imports of ``fcl`` get ``simdop.fcl``, and ``trimesh.collision`` has simdop's manager.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import simdop.fcl
import simdop.trimesh


def main(files: list[str]) -> int:
    """Run the files; return pytest's exit code."""
    sys.modules["fcl"] = simdop.fcl
    import trimesh

    for name in simdop.trimesh.__all__:
        setattr(trimesh.collision, name, getattr(simdop.trimesh, name))
    folder = str(Path(files[0]).parent)
    return int(pytest.main(["-p", "no:cacheprovider", "-c", "/dev/null", "--rootdir", folder, "-q", *files]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
