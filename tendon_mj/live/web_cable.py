"""Draws the tendons of a simulation into a viser scene."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_mj.live.scene_cable import new_scene, scene_cable
from tendon_mj.live.simulation import LiveSimulation

_THICKER = 3.0  # than MuJoCo's own tendon, which is hard to see in a browser
_MARK = 6.0  # size of a slipping guide over that tendon's radius
_SLIPPING = (230, 0, 122)  # magenta, as the plugin draws it


class WebCable:
    """Lines in the colours of tension, and points where a tendon slips.

    Args:
        server: viser's.
        simulation: whose tendons are drawn.
    """

    def __init__(self, server: Any, simulation: LiveSimulation) -> None:
        self._simulation = simulation
        self._scene = new_scene(simulation.model)
        width = float(simulation.model.tendon_width.max(initial=0.0))
        nothing = np.zeros((1, 2, 3))
        self._spans = server.scene.add_line_segments(
            "/tendons", nothing, nothing.astype(np.uint8), thickness=2.0 * _THICKER * width
        )
        self._marks = server.scene.add_point_cloud(
            "/slipping",
            nothing[:, 0],
            _SLIPPING,
            point_size=_MARK * width,
            point_shape="circle",
            precision="float32",
        )

    def draw(self) -> None:
        """Draw the tendons as they are now."""
        with self._simulation.held():
            cable = scene_cable(self._simulation.model, self._simulation.data, self._scene)
        if len(cable.ends):
            self._spans.points = cable.ends.astype(np.float32)
            self._spans.colors = np.repeat(cable.colours[:, None], 2, axis=1)
        self._marks.visible = len(cable.slipping) > 0
        if len(cable.slipping):
            self._marks.points = cable.slipping.astype(np.float32)
