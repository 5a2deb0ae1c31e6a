"""The notebook of the examples runs, and shows a picture."""

from __future__ import annotations

import base64
from pathlib import Path

import nbclient
import nbformat
import numpy as np
import pytest
from matplotlib import image

NOTEBOOK = Path(__file__).parent.parent / "examples" / "from_urdf_to_path.ipynb"


@pytest.mark.filterwarnings("ignore")
def test_the_notebook_draws_a_path(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(NOTEBOOK.parent)}})
    client.execute()
    pictures = [
        output["data"]["image/png"]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 1
    (tmp_path / "picture.png").write_bytes(base64.b64decode(pictures[0]))
    pixels = image.imread(tmp_path / "picture.png")[:, :, :3]
    # The robot and the objects are coloured, and the background is white.
    assert np.mean(np.ptp(pixels, axis=2) > 0.1) > 0.02
    assert np.mean((pixels > 0.99).all(axis=2)) > 0.2
