"""The sheaths of all worlds of one `mujoco_warp.Data`, as their user sees them."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath.law import check_range
from tendon_mj.warp.allocate import allocate
from tendon_mj.warp.simulated import Simulated
from tendon_mj.warp.support import PARAMETERS


class Sheaths:
    """The sheaths of all worlds; every array is on the device, its first axis the worlds.

    Attributes:
        names: of the sheaths, in the order of the other axis.
        nworld: number of worlds.
        parameters: name to (worlds, sheaths) float32, what each world has of its own.
        input_tension, output_tension: (worlds, sheaths) float32, of the latest evaluation [N].
        tension: (worlds, segments) float32, along all tendons, input side first [N].
        segments: name of each sheath to its segments in ``tension``.
        unsolved: (worlds, sheaths) int32, evaluations without a solution since the reset.
    """

    def __init__(self, found: dict[str, Simulated], reels: list[int], nworld: int) -> None:
        """Put sheaths on the device as they are in a simulation of MuJoCo's.

        Args:
            found: each by name.
            reels: address of the control of each one's reel, −1 without one.
            nworld: number of worlds, all alike.
        """
        self.names = tuple(found)
        self.nworld = nworld
        self.tendons: Any = allocate(found, reels, nworld)
        self.parameters = {name: getattr(self.tendons, name) for name in PARAMETERS}
        self.input_tension = self.tendons.input_tension
        self.output_tension = self.tendons.output_tension
        self.tension = self.tendons.tension_out
        self.unsolved = self.tendons.unsolved
        ends = np.cumsum([0, *(len(sheath.segments) for sheath in found.values())])
        self.segments = {
            name: slice(int(ends[k]), int(ends[k + 1])) for k, name in enumerate(self.names)
        }

    def set(self, parameter: str, values: ArrayLike, sheath: str | None = None) -> None:
        """Set a parameter from the next evaluation on; checks and copies from the host.

        On the device, and in a captured graph, write into ``parameters`` instead.

        Args:
            parameter: one of ``parameters``.
            values: that broadcast to (worlds, sheaths), or to (worlds,) with ``sheath``.
            sheath: name of the one whose it is; all without.

        Raises:
            InvalidValueError: a value outside its range, or an array of another shape.
            UnknownNameError: no such parameter or sheath.
        """
        if parameter not in self.parameters:
            raise UnknownNameError("parameter", parameter, self.parameters, "tendon_mj.warp")
        if sheath is not None and sheath not in self.names:
            raise UnknownNameError("sheath", sheath, self.names)
        given = np.asarray(values, float)
        for value in (given.min(), given.max()) if given.size else ():
            check_range(parameter, float(value), "tendon_mj.warp")
        table = self.parameters[parameter].numpy()
        part = table if sheath is None else table[:, self.names.index(sheath)]
        try:
            part[...] = np.broadcast_to(given, part.shape)
        except ValueError:
            raise InvalidValueError(
                f"{parameter}: values of shape {given.shape} do not broadcast to {part.shape}"
            ) from None
        wp.copy(self.parameters[parameter], wp.array(table, dtype=wp.float32))
