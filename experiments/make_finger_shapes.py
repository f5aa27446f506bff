"""Writes the shapes that the finger is drawn with: `models/finger/shapes.xml`, `stand_shapes.xml`.

`python -m experiments.make_finger_shapes`, after a change of the finger's parameters or its shapes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from tendon_mj.models import Finger, Mesh, conduit_shape, palm_shapes, phalanx_shapes

FOLDER = Path(__file__).parents[1] / "models" / "finger"
DIGITS = 5  # of a coordinate [m], 10 µm


def write_shapes(path: Path, shapes: Mapping[str, Mesh]) -> None:
    """Write meshes as the assets of an MJCF file to be included."""
    root = ElementTree.Element("mujoco")
    asset = ElementTree.SubElement(root, "asset")
    for name, shape in shapes.items():
        vertices = " ".join(f"{x + 0.0:.6g}" for x in np.round(shape.vertices.ravel(), DIGITS))
        faces = " ".join(map(str, shape.faces.ravel()))
        ElementTree.SubElement(asset, "mesh", name=name, vertex=vertices, face=faces)
    root.insert(0, ElementTree.Comment(" Made by python -m experiments.make_finger_shapes. "))
    ElementTree.indent(root)
    path.write_text(ElementTree.tostring(root, encoding="unicode") + "\n", encoding="utf-8")


def main() -> None:
    """Write both files."""
    finger = Finger()
    write_shapes(FOLDER / "shapes.xml", phalanx_shapes(finger))
    conduits = {f"{t}_conduit": conduit_shape(finger, t) for t in ("flexor", "extensor")}
    write_shapes(FOLDER / "stand_shapes.xml", {**palm_shapes(finger), **conduits})


if __name__ == "__main__":
    main()
