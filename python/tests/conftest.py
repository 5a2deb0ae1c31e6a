"""Fixtures of all tests."""

import os
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture
def rng() -> np.random.Generator:
    """A random generator, with the same numbers in each run."""
    return np.random.default_rng(7)


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder with data sets: ``SIMDOP_DATA``, or ``shared/data`` beside the project."""
    beside = Path(__file__).parents[3] / "shared" / "data"
    folder = Path(os.environ.get("SIMDOP_DATA") or beside)
    if not (folder / "planning").is_dir():
        message = f"there are no data sets in {folder}: set SIMDOP_DATA"
        if os.environ.get("SIMDOP_REQUIRE_DATA"):
            pytest.fail(message)
        pytest.skip(message)
    return folder
