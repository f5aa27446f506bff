"""Parameters of sheaths and gains of servos by name, live in the data of a simulation."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, UnknownKeyError, UnusedKeyError
from tendon_mj.plugin import (
    CHOSEN_STIFFNESS,
    GAINS,
    PARAMETERS,
    check_gain,
    servos,
    sheath_arrays,
    sheaths,
    unused_parameters,
)
from tendon_mj.sheath import LAW, check_range


def check_live(name: str, value: float) -> None:
    """Refuse a value of ``<sheath>.<parameter>`` or ``<servo>.<gain>`` outside its range.

    Raises:
        InvalidValueError: names the parameter, the value and the range.
    """
    owner, kind = name.rsplit(".", 1)
    if kind in LAW:
        check_range(kind, value, name)
    elif kind in GAINS:
        check_gain(kind, value, owner)
    elif not np.isfinite(value):
        raise InvalidValueError(f"{name} = {value} must be finite")


def as_it_acts(parameter: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a sheath's parameter in states, as they act.

    The stiffness that no model states is in the state from the first evaluation on, and 0 before.
    """
    chosen = (values == 0.0) & (parameter == "axial_stiffness")
    return np.where(chosen, CHOSEN_STIFFNESS, values)


_FIXED = ("period", "delay")  # they say how much memory a servo has


class Parameters(MutableMapping[str, float]):
    """``<sheath>.<parameter>`` and ``<servo>.<gain>`` to value, live in `mjData.plugin_state`.

    A change acts from the next evaluation on; a reset brings back what the model says. The
    unstretched length is laid down from ``pretension`` at the first evaluation after a reset, so
    set that before it. Writing goes to this data only, which makes a friction of its own for each
    of many simulations of one model cheap.

    A parameter that a sheath has no use for is none of them, as the pretension of a tendon whose
    input tension a motor gives.

    Args:
        model: with sheaths.
        data: of that model; or any (npluginstate,) array, such as the tail of a state vector.

    Raises:
        UnknownKeyError: no such sheath or parameter, with the nearest.
        UnusedKeyError: a parameter that the sheath has no use for, and why.
        InvalidValueError: a value that is no number or outside its range; data of another model,
            of other numbers, that holds no states of sheaths, or that cannot be written.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData | NDArray[np.float64]) -> None:
        state = data if isinstance(data, np.ndarray) else getattr(data, "plugin_state", None)
        if not isinstance(state, np.ndarray) or state.dtype != np.float64:
            kind = f"array of {data.dtype}" if isinstance(data, np.ndarray) else type(data).__name__
            raise InvalidValueError(
                f"data must be an MjData or an array of float64, whose numbers are changed in "
                f"place, not: {kind}"
            )
        self._state: NDArray[np.float64] = state
        if self._state.shape != (model.npluginstate,):
            raise InvalidValueError(
                f"the plugin state of this model has shape ({model.npluginstate},), the data's has "
                f"{self._state.shape}: it belongs to another model, or is more than that part"
            )
        known = sheaths(model)
        for name, instance in known.items():  # which refuses what is no state of this model
            sheath_arrays(model, state, name, instance.state)
        self._unused = {
            f"{name}.{parameter}": why
            for name, instance in known.items()
            for parameter, why in unused_parameters(model, instance.instance).items()
        }
        self._address = {
            f"{name}.{parameter}": instance.state + k
            for name, instance in known.items()
            for k, parameter in enumerate(PARAMETERS)
            if f"{name}.{parameter}" not in self._unused
        }
        self._address |= {
            f"{name}.{gain}": instance.state + k
            for name, instance in servos(model).items()
            for k, gain in enumerate(GAINS)
            if gain not in _FIXED
        }

    def _find(self, name: str) -> int:
        if isinstance(name, str) and name in self._unused:
            raise UnusedKeyError(f"{name} {self._unused[name]}")
        if not isinstance(name, str) or name not in self._address:
            raise UnknownKeyError("parameter", str(name), self._address)
        return self._address[name]

    def __getitem__(self, name: str) -> float:
        value = self._state[self._find(name)]
        return float(as_it_acts(name.rsplit(".", 1)[1], value))

    def __setitem__(self, name: str, value: float) -> None:
        address = self._find(name)
        try:
            number = float(value) if np.ndim(value) == 0 else None
        except (TypeError, ValueError, OverflowError):
            number = None
        if number is None:
            raise InvalidValueError(f"{name}: {value!r} is no number")
        check_live(name, number)
        if not self._state.flags.writeable:
            raise InvalidValueError(f"{name}: the array of the plugin state is read-only")
        self._state[address] = number

    def __delitem__(self, name: str) -> None:
        raise InvalidValueError(f"{name} cannot be removed, only set")

    def __iter__(self) -> Iterator[str]:
        return iter(self._address)

    def __len__(self) -> int:
        return len(self._address)
