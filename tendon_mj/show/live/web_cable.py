"""Draws the tendons of a simulation into a viser scene.

They are rows of points: these alone have exactly the colour that they are given in a browser, while
lines and meshes go through the tone mapping of its renderer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.show.live.scene_cable import SceneCable, new_scene, scene_cable
from tendon_mj.show.live.simulation import LiveSimulation
from tendon_mj.typing import FloatArray

_THICKER = 2.5  # than MuJoCo's own tendon, which is hard to see in a browser
_MARK = 5.0  # size of a slipping guide over the tendon's radius
_APART = 0.5  # between two points, over the radius that is drawn
_MOST = 8000  # points of all tendons together
_SLIPPING = (230, 0, 122)  # magenta, as the plugin draws it


def row_of_points(
    cable: SceneCable, spacing: float, most: int = _MOST
) -> tuple[FloatArray, NDArray[np.uint8]]:
    """Points along all spans, both ends of each among them.

    Args:
        cable: its spans.
        spacing: between two points at most [m], unless that takes more than ``most`` points.
        most: number of points.

    Returns:
        (k, 3) points [m], and (k, 3) red, green and blue, 0 to 255.
    """
    lengths = np.linalg.norm(cable.ends[:, 1] - cable.ends[:, 0], axis=1)
    if not lengths.size:
        return np.zeros((0, 3)), np.zeros((0, 3), np.uint8)
    spacing = max(spacing, float(lengths.sum()) / max(1, most - 2 * len(lengths)))
    counts = np.ceil(lengths / spacing).astype(int) + 1
    span = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(span)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (place / np.maximum(1, counts - 1)[span])[:, None]
    points = (1.0 - share) * cable.ends[span, 0] + share * cable.ends[span, 1]
    return points, cable.colours[span]


class WebCable:
    """Tendons in the colours of their tension, and marks where they slip.

    Args:
        server: viser's.
        simulation: whose tendons are drawn.
    """

    def __init__(self, server: Any, simulation: LiveSimulation) -> None:
        self._simulation = simulation
        self._scene = new_scene(simulation.model)
        width = float(simulation.model.tendon_width.max(initial=1e-6))
        self._spacing = _APART * _THICKER * width
        self._spans = _add_points(server, "/tendons", _THICKER * width)
        self._marks = _add_points(server, "/slipping", _MARK * width)

    def draw(self) -> None:
        """Draw the tendons as they are now."""
        with self._simulation.held():
            cable = scene_cable(self._simulation.model, self._simulation.data, self._scene)
        _set_points(self._spans, *row_of_points(cable, self._spacing))
        marks = np.tile(np.array(_SLIPPING, np.uint8), (len(cable.slipping), 1))
        _set_points(self._marks, cable.slipping, marks)


def _add_points(server: Any, name: str, size: float) -> Any:
    return server.scene.add_point_cloud(
        name,
        np.zeros((1, 3), np.float32),
        np.zeros((1, 3), np.uint8),
        point_size=size,
        point_shape="circle",
        point_shading="flat",
        precision="float32",
        visible=False,
    )


def _set_points(handle: Any, points: FloatArray, colours: NDArray[np.uint8]) -> None:
    handle.visible = len(points) > 0
    if len(points):
        handle.points, handle.colors = points.astype(np.float32), colours
