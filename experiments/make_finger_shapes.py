"""Writes the shapes that the finger is drawn with: `models/finger/shapes.xml`, `stand_shapes.xml`.

`python -m experiments.make_finger_shapes`, after a change of the finger's parameters or its shapes:
bone, flesh and skin, as cut open along the tendons' plane. They are for the eye alone. The tendons
lie in the plane y = 0; every shape lies behind it, so that no shape hides or tints a tendon, and
the phalanges of one joint meet in it without an edge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.models import JOINTS, Finger, sheath_points
from tendon_mj.typing import FloatArray, IntArray

FOLDER = Path(__file__).parents[1] / "models" / "finger"
DIGITS = 5  # of a coordinate [m], 10 µm
_KNUCKLE = 0.011  # radius of the skin around the MCP, which holds the extensor [m]
_WRIST = 0.0135  # radius of the skin where the palm ends [m]
_RIND = 0.0008  # of skin around the flesh [m]
_WAIST = 0.0006  # by which a phalanx is thinner between its joints [m]
_SKIN_CUT, _FLESH_CUT = 0.0054, 0.005  # where skin and flesh are cut open, behind the tendons [m]
_STEP = 0.00015  # by which each phalanx is cut before the last, as planes in one place flicker [m]
_DEPTH = 0.8  # depth of skin and flesh behind the cut over their radius
_BONE_DEPTH = 0.7  # how far a bone stands out of the flesh over its radius
_HEAD = {"palm": 0.0042, "mcp": 0.0034, "pip": 0.0027, "dip": 0.002}  # radius of a bone's head [m]
_SHAFT = 0.68  # radius of a bone's shaft over that of its head
_JOINT_SPACE = 0.0005  # between a bone's head and the next bone [m]
_OVERLAP = 0.013  # of the palm over the conduits' ends [m]
_ALONG, _AROUND = 22, 10  # faces of a shape along the finger and around half of it
_CONDUIT = 0.0027, 0.0036  # inner and outer radius of a conduit [m]


@dataclass(frozen=True)
class Mesh:
    """A closed surface.

    Attributes:
        vertices: (n, 3) [m].
        faces: (m, 3) numbers of vertices, counter-clockwise as seen from outside.
    """

    vertices: FloatArray
    faces: NDArray[np.int32]


def half_round(x: FloatArray, radius: FloatArray, cut: float, depth: float) -> Mesh:
    """Half of a body of revolution about the x axis, on the plane y = ``cut``.

    (n,) stations ``x`` have (n,) radii [m]; ``depth``: extent along y over the radius, signed.
    """
    # the plane has its own vertices, or the edge would be shaded as if it were round
    around = np.pi * np.array([*np.linspace(0.0, 1.0, _AROUND + 1), 1.0, 0.0])
    section = np.stack([depth * np.sin(around), np.cos(around)], axis=-1)
    points = radius[:, None, None] * section + np.array([cut, 0.0])
    along = np.broadcast_to(x[:, None, None], (*points.shape[:2], 1))
    return _tube(np.concatenate([along, points], axis=-1), flip=depth > 0.0)


def half_pipe(points: ArrayLike, inner: float, outer: float) -> Mesh:
    """The half behind the plane y = 0 of a pipe along an (n, 3) path in it; radii [m]."""
    path = np.asarray(points, float)
    heading = np.diff(path, axis=0)
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    mean = np.vstack([heading[:1], heading[:-1] + heading[1:], heading[-1:]])
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    normal = np.stack([-mean[:, 2], np.zeros(len(mean)), mean[:, 0]], axis=-1)
    miter = np.einsum("ij,ij->i", mean, np.vstack([heading, heading[-1:]]))
    around = np.linspace(0.0, np.pi, _AROUND + 1)
    arc = np.stack([np.cos(around), np.sin(around)], axis=-1)
    section = np.vstack([outer * arc, inner * arc[::-1]])
    across, behind = (normal / miter[:, None])[:, None], np.array([0.0, 1.0, 0.0])
    rings = path[:, None] + across * section[:, :1] + behind * section[:, 1:]
    return _tube(rings, flip=True)


def phalanx_shapes(finger: Finger) -> dict[str, Mesh]:
    """Bone, flesh and skin of every phalanx: `mcp_bone`, …, in the frame of its body."""
    skin = _skin_radii(finger)
    shapes: dict[str, Mesh] = {}
    for k, (name, joint) in enumerate(finger.joints.items()):
        last, step = name == JOINTS[-1], (k + 1) * _STEP
        length = joint.length - joint.radius if last else joint.length
        start = _HEAD[("palm", *JOINTS)[k]] + _JOINT_SPACE
        shapes |= _shapes(name, 0.0, length, (skin[k], skin[k + 1]), step)
        shapes[f"{name}_bone"] = _bone(start, length, _HEAD[name])
    return shapes


def palm_shapes(finger: Finger) -> dict[str, Mesh]:
    """Bone, flesh and skin of the palm from the wrist to the MCP: `palm_bone`, …."""
    start = -finger.palm_length - _OVERLAP
    shapes = _shapes("palm", start, 0.0, (_WRIST, _skin_radii(finger)[0]), 0.0, flat=True)
    return {**shapes, "palm_bone": _bone(start, 0.0, _HEAD["palm"])}


def conduit_shape(finger: Finger, tendon: str) -> Mesh:
    """The conduit around a tendon's sheath, open in front of the tendon."""
    return half_pipe(sheath_points(finger, tendon)[1:], *_CONDUIT)


def _skin_radii(finger: Finger) -> tuple[float, ...]:
    """Radius of the skin around every joint, and at the tip [m]."""
    return (_KNUCKLE, finger.pip.radius, finger.dip.radius, finger.dip.radius)


def _shapes(
    name: str,
    start: float,
    end: float,
    radii: tuple[float, float],
    step: float,
    *,
    flat: bool = False,
) -> dict[str, Mesh]:
    """Skin and flesh between two joints, round about both, or with a flat start."""
    shapes = {}
    for part, thinner, cut in (("skin", 0.0, _SKIN_CUT), ("flesh", _RIND, _FLESH_CUT)):
        first, last = (radius - thinner for radius in radii)
        angle = np.linspace(0.0, 0.5 * np.pi, _ALONG // 3)
        share = np.linspace(0.0, 1.0, _ALONG // 2)[1:-1]
        between = first + (last - first) * share - _WAIST * np.sin(np.pi * share) ** 2
        x = [start + share * (end - start), end + last * np.sin(angle)]
        radius = [between, last * np.cos(angle)]
        if flat:
            x, radius = [np.array([start]), *x], [np.array([first]), *radius]
        else:
            x, radius = [start - first * np.cos(angle), *x], [first * np.sin(angle), *radius]
        shapes[f"{name}_{part}"] = half_round(
            np.concatenate(x), np.maximum(np.concatenate(radius), 1e-5), cut - step, _DEPTH
        )
    return shapes


def _bone(start: float, end: float, head: float) -> Mesh:
    """A bone that widens to its base at ``start`` and to its round head about ``end``."""
    shaft, base = _SHAFT * head, 1.15 * head
    angle = np.linspace(0.0, 0.5 * np.pi, 6)
    neck = np.sqrt(head**2 - shaft**2)
    share = np.linspace(0.0, 1.0, _ALONG // 2)[1:-1]
    rounding = 0.4 * base
    tip = np.linspace(-np.arccos(_SHAFT), 0.5 * np.pi, 12)
    x = [
        start + rounding * (1.0 - np.cos(angle)),
        start + rounding + share * (end - neck - start - rounding),
        end + head * np.sin(tip),
    ]
    radius = [
        (base - rounding) + rounding * np.sin(angle),
        shaft + (base - shaft) * np.exp(-4.0 * share),
        head * np.cos(tip),
    ]
    profile = np.maximum(np.concatenate(radius), 1e-5)
    return half_round(np.concatenate(x), profile, _FLESH_CUT, -_BONE_DEPTH)


def _triangles(*corners: tuple[IntArray, IntArray, IntArray]) -> IntArray:
    return np.vstack([np.stack(three, axis=-1) for three in corners])


def _tube(rings: FloatArray, *, flip: bool) -> Mesh:
    """Closed surface through (n, m, 3) rings of points, with lids on both ends."""
    count, size = rings.shape[:2]
    here = np.arange(size)
    there = np.roll(here, -1)
    faces = [
        _triangles((a + here, a + there, b + here), (a + there, b + there, b + here))
        for a, b in zip(size * np.arange(count - 1), size * np.arange(1, count), strict=True)
    ]
    for start, way in ((0, -1), (size * (count - 1), 1)):
        # the two halves of a ring run alongside each other: strips between them close it
        low, high = np.arange(size // 2), size - 1 - np.arange(size // 2)
        lid = _triangles((low[:-1], low[1:], high[:-1]), (low[1:], high[1:], high[:-1]))
        if size % 2:
            lid = np.vstack([lid, [[low[-1], low[-1] + 1, high[-1]]]])
        faces.append(start + lid[:, ::way])
    joined = np.vstack(faces).astype(np.int32)
    return Mesh(rings.reshape(-1, 3), joined[:, ::-1] if flip else joined)


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
