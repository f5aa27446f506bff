"""View of a sheath by name, in a simulation or in the states of many."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from tendon_mj.attach.parameters import as_it_acts, check_live
from tendon_mj.errors import InvalidValueError, UnknownAttributeError, UnknownNameError
from tendon_mj.plugin import PARAMETERS, sheath_arrays, sheaths, unused_parameters
from tendon_mj.typing import FloatArray

_FULL, _ALL = mujoco.mjtState.mjSTATE_FULLPHYSICS, mujoco.mjtState.mjSTATE_INTEGRATION


class SheathView:
    """A sheath's quantities at the latest evaluation, and its parameters, live.

    Of the states of many simulations, every quantity has their axes first. The parameters of
    `Parameters` are attributes that can be set: ``view.friction = 0.2`` acts from the next
    evaluation on, in this data or in these states only. Setting one raises InvalidValueError where
    it is no number, outside its range, or of no use to this sheath.

    Attributes:
        name: of the sheath.
        tendon: that runs in it.
    """

    __slots__ = ("_instance", "_model", "_plugin", "_states", "name", "tendon")
    _instance: int
    _model: mujoco.MjModel
    _plugin: int
    _states: FloatArray
    name: str
    tendon: str

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData | FloatArray, sheath: str
    ) -> None:
        known = sheaths(model)
        by_tendon = {found.tendon: name for name, found in known.items()}
        name = sheath if sheath in known else by_tendon.get(sheath, "")
        if not name:
            raise UnknownNameError("sheath or sheathed tendon", sheath, {*known, *by_tendon})
        for attribute, value in (
            ("_model", model),
            ("_states", _plugin_states(model, data)),
            ("_instance", known[name].state),
            ("_plugin", known[name].instance),
            ("name", name),
            ("tendon", known[name].tendon),
        ):
            object.__setattr__(self, attribute, value)

    @property
    def input_tension(self) -> Any:
        """T_in [N]."""
        return self.tension[..., 0]

    @property
    def output_tension(self) -> Any:
        """T_out [N]."""
        return self.tension[..., -1]

    @property
    def tension(self) -> FloatArray:
        """(…, n+1) tension of each segment, input side first [N]."""
        found = self._read()
        stiffness = found.state["law"]["axial_stiffness"]
        return np.asarray(stiffness[..., None] * found.segments["tension"])

    @property
    def positions(self) -> FloatArray:
        """(…, n+2, 3) points of the path, input end first: its ends and the guides between [m]."""
        return np.array(self._read().path)

    @property
    def bend_angle(self) -> FloatArray:
        """(…, n) bend at each guide, input side first [rad]."""
        return np.array(self._read().guides["angle"])

    @property
    def slip(self) -> FloatArray:
        """(…, n) +1 where tendon slides towards the input, −1 towards the output, 0 at rest."""
        guides = self._read().guides
        return np.where(guides["flow"] != 0.0, guides["slip"], 0.0)

    @property
    def friction_work(self) -> FloatArray:
        """(…, n) friction work at each guide since the reset [J]."""
        found = self._read()
        not_counted = found.state["has_trial"][..., None] != 0.0  # by a finished step
        guides = found.guides
        latest = np.where(not_counted, guides["trial_friction_work"], 0.0)
        return np.asarray(guides["friction_work"] + latest)

    @property
    def rebound(self) -> Any:
        """How often the state was found to be another model's, or none, and bound anew."""
        return self._read().state["rebound"].astype(int)[()]

    @property
    def unsolved(self) -> Any:
        """Evaluations whose flow was not solved since the reset."""
        return self._read().state["unsolved"].astype(int)[()]

    def __getattr__(self, name: str) -> Any:
        if name not in PARAMETERS:
            raise UnknownAttributeError("parameter", name, PARAMETERS, f"sheath {self.name!r}")
        return as_it_acts(name, self._states[..., self._column(name)])[()]

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in PARAMETERS:
            raise UnknownAttributeError("parameter", name, PARAMETERS, f"sheath {self.name!r}")
        place, shape = f"{self.name}.{name}", self._states.shape[:-1]
        why = unused_parameters(self._model, self._plugin).get(name)
        if why:
            raise InvalidValueError(f"{place} {why}")
        try:
            values = np.asarray(value, np.float64)
        except (TypeError, ValueError, OverflowError):
            raise InvalidValueError(
                f"{place}: {value!r} is no number, nor an array of some"
            ) from None
        for one in np.unique(values):
            check_live(place, float(one))
        try:
            values = np.broadcast_to(values, shape)
        except ValueError:
            raise InvalidValueError(
                f"{place}: values of shape {values.shape} are not of shape {shape}, one a state"
            ) from None
        if not self._states.flags.writeable:
            raise InvalidValueError(f"{place}: the array of the states is read-only")
        self._states[..., self._column(name)] = values

    def __dir__(self) -> list[str]:
        return sorted({*object.__dir__(self), *PARAMETERS})

    def __repr__(self) -> str:
        shape = self._states.shape[:-1]
        return f"SheathView({self.name!r} on tendon {self.tendon!r}, states {shape})"

    def _column(self, parameter: str) -> int:
        return self._instance + list(PARAMETERS).index(parameter)

    def _read(self) -> Any:
        return sheath_arrays(self._model, self._states, self.name, self._instance)


def view_sheath(model: mujoco.MjModel, data: mujoco.MjData | FloatArray, sheath: str) -> SheathView:
    """View of a sheath by its name or its tendon's.

    Args:
        model: with sheaths.
        data: of that model; or states of it, (…, nstate) of `mjSTATE_FULLPHYSICS`, as a rollout
            returns them, or of `mjSTATE_INTEGRATION`, or (…, npluginstate).
        sheath: its name, or that of its tendon.

    Raises:
        UnknownNameError: no such sheath or sheathed tendon, with the nearest.
        InvalidValueError: an array that is none of these, or data of another model.
    """
    return SheathView(model, data, sheath)


def _plugin_states(model: mujoco.MjModel, data: mujoco.MjData | FloatArray) -> FloatArray:
    """The plugins' part of states, which comes last in each; shares their memory."""
    if not isinstance(data, np.ndarray):
        if data.plugin_state.size != model.npluginstate:
            raise InvalidValueError(
                f"data of another model: it holds {data.plugin_state.size} numbers of plugin "
                f"state, this model {model.npluginstate}"
            )
        return np.asarray(data.plugin_state)
    sizes = {
        "npluginstate": int(model.npluginstate),
        "FULLPHYSICS": mujoco.mj_stateSize(model, int(_FULL)),
        "INTEGRATION": mujoco.mj_stateSize(model, int(_ALL)),
    }
    if data.dtype != np.float64 or data.ndim < 1 or data.shape[-1] not in sizes.values():
        said = ", ".join(f"{size} ({name})" for name, size in sizes.items())
        raise InvalidValueError(
            f"states of shape {data.shape} and type {data.dtype} are none of this model: their "
            f"last axis is one of {said}, of float64"
        )
    return data[..., data.shape[-1] - int(model.npluginstate) :]
