"""User's view of the sheaths of all worlds of one `mujoco_warp.Data`."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError, UnknownNameError, UnusedKeyError
from tendon_mj.plugin import sheaths
from tendon_mj.sheath import check_range
from tendon_mj.typing import FloatArray
from tendon_mj.warp.cells import allocate_groups
from tendon_mj.warp.support import LIVE_PARAMETERS, Simulated, layout_of, rows_of
from tendon_mj.warp.transfer import allocate


class Sheaths:
    """The sheaths of all worlds; every array is on the device, its first axis the worlds.

    Attributes:
        names: of the sheaths, in the order of the other axis.
        tendon_names: of their tendons, in the same order.
        layout: addresses of the sheaths' numbers, that of their model.
        nworld: number of worlds.
        parameters: name to (worlds, sheaths) float32, of each world.
        of_model: name to (sheaths,) values with which all worlds began.
        input_tension, output_tension: (worlds, sheaths) float32, of the latest evaluation [N].
        tension: (worlds, segments) float32, along all tendons, input side first [N].
        segments: name of each sheath to its segments in ``tension``.
        unsolved: (worlds, sheaths) int32, evaluations without a solution since the reset.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        simulated: dict[str, Simulated],
        unused: Mapping[str, Mapping[str, str]],
        nworld: int,
    ) -> None:
        """Put sheaths on the device as they are in a simulation of MuJoCo's.

        Args:
            model: with sheaths.
            simulated: each by name.
            unused: by name of a sheath its parameters that have no use, and why.
            nworld: number of worlds, all alike.
        """
        self.names = tuple(simulated)
        self.tendon_names = tuple(instance.tendon for instance in sheaths(model).values())
        self._unused = unused
        self.layout = layout_of(simulated)
        self.nworld = nworld
        self.asks = False  # for the actuators' forces, within their computation
        self.tendons: Any = allocate(model, simulated, nworld)
        self.groups: Any = allocate_groups(model, simulated, rows_of(simulated), nworld)
        self.written = [  # cfrc_ext and cfrc_int with the sheaths' reactions
            wp.full(
                (nworld, model.nbody), wp.spatial_vector(*[np.nan] * 6), dtype=wp.spatial_vector
            )
            for _ in range(2)
        ]
        self.parameters = {name: getattr(self.tendons, name) for name in LIVE_PARAMETERS}
        self.of_model = {name: 1.0 * table.numpy()[0] for name, table in self.parameters.items()}
        self.input_tension = self.tendons.input_tension
        self.output_tension = self.tendons.output_tension
        self.tension = self.tendons.tension_out
        self.unsolved = self.tendons.unsolved
        ends = np.cumsum([0, *(len(sheath.segments) for sheath in simulated.values())])
        self.segments = {
            name: slice(int(ends[k]), int(ends[k + 1])) for k, name in enumerate(self.names)
        }

    def set(self, parameter: str, values: ArrayLike, sheath: str | None = None) -> None:
        """Set a parameter from the next evaluation on; checks and copies from the host.

        On the device, and in a captured graph, write into ``parameters`` instead.

        Args:
            parameter: one of ``parameters``.
            values: a number; (worlds, sheaths) or two dimensions that broadcast to it; with
                ``sheath`` (worlds,).
            sheath: its name, or that of its tendon; default: all.

        Raises:
            InvalidValueError: not numeric, outside its range, or of another shape; an array of one
                dimension needs ``sheath``.
            UnknownNameError: no such parameter or sheath.
            UnusedKeyError: a parameter that the sheath has no use for, and why.
        """
        if sheath in self.tendon_names:
            sheath = self.names[self.tendon_names.index(sheath)]
        self.check_use(parameter, sheath)
        try:
            given = np.asarray(values, float)
        except (TypeError, ValueError):
            raise InvalidValueError(f"{parameter}: {values!r} is not numeric") from None
        for value in (given.min(), given.max()) if given.size else ():
            check_range(parameter, float(value), "tendon_mj.warp")
        table = self.parameters[parameter].numpy()
        part = table if sheath is None else table[:, self.names.index(sheath)]
        try:
            if sheath is None and given.ndim == 1:  # of worlds or of sheaths?
                raise ValueError
            part[...] = np.broadcast_to(given, part.shape)
        except ValueError:
            shape = "(worlds, sheaths)" if sheath is None else "(worlds,)"
            raise InvalidValueError(
                f"{parameter}: values of shape {given.shape} are not of shape {part.shape}, {shape}"
                + ("; give values[:, None] for one a world" if sheath is None else "")
            ) from None
        wp.copy(self.parameters[parameter], wp.array(table, dtype=wp.float32))

    def columns(self, patterns: Iterable[str]) -> list[int]:
        """Columns of the sheaths that names or patterns of sheaths or of their tendons mean.

        Raises:
            UnknownNameError: one means none.
        """
        names = (*self.names, *self.tendon_names)
        found: dict[int, None] = {}
        for pattern in patterns:
            means = [pattern] if pattern in names else fnmatch.filter(names, pattern)
            if not means:
                raise UnknownNameError("sheath or sheathed tendon", pattern, names)
            found |= {names.index(name) % len(self.names): None for name in means}
        return list(found)

    def check(
        self, parameter: str, columns: Iterable[int], low: FloatArray, high: FloatArray
    ) -> None:
        """Check ranges of a parameter in some columns.

        Raises:
            InvalidValueError: an end outside the parameter's range, or low above high.
        """
        for k, *ends in zip(columns, low, high, strict=True):
            for end in ends:
                check_range(parameter, float(end), self.names[k])
            if ends[0] > ends[1]:
                name = f"{self.names[k]}.{parameter}"
                raise InvalidValueError(f"{name}: {ends[0]:g} is above {ends[1]:g}")

    def check_use(self, parameter: str, sheath: str | None) -> None:
        """Check that a parameter is one, and that a sheath, or each, has a use for it.

        Raises:
            UnknownNameError, UnusedKeyError: see `set`.
        """
        if parameter not in self.parameters:
            raise UnknownNameError("parameter", parameter, self.parameters, "tendon_mj.warp")
        if sheath is not None and sheath not in self.names:
            raise UnknownNameError("sheath", sheath, self.names)
        for name in self.names if sheath is None else (sheath,):
            why = self._unused[name].get(parameter)
            if why:
                others = "; set that of each other sheath by its name" if sheath is None else ""
                raise UnusedKeyError(f"{name}.{parameter} {why}{others}")
