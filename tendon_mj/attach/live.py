"""Parameters and quantities of sheaths and servos, live in one simulation or in many states."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from typing import Any

import mujoco
import numpy as np

from tendon_mj import plugin
from tendon_mj.attach.stiffness_limit import step_warning
from tendon_mj.errors import (
    InvalidValueError,
    TendonWarning,
    UnknownAttributeError,
    UnknownKeyError,
    UnknownNameError,
    UnusedKeyError,
)
from tendon_mj.sheath import LAW, check_in_range
from tendon_mj.typing import FloatArray

_FULL_STATE, _ALL_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS, mujoco.mjtState.mjSTATE_INTEGRATION
_FIXED_GAINS = ("period", "delay")  # gains that state how much memory a servo has


class _States:
    """Numbers of a model's plugins in `mjData`, or in the states of many simulations.

    ``numbers`` is (…, npluginstate); it shares its memory with the data.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData | FloatArray) -> None:
        self.model = model
        states = data if isinstance(data, np.ndarray) else getattr(data, "plugin_state", None)
        if not isinstance(states, np.ndarray) or states.dtype != np.float64:
            kind = f"array of {data.dtype}" if isinstance(data, np.ndarray) else type(data).__name__
            raise InvalidValueError(
                f"data must be an MjData or an array of float64, whose numbers are changed in "
                f"place, not: {kind}"
            )
        size = int(model.npluginstate)
        sizes = {"npluginstate": size}
        if isinstance(data, np.ndarray):
            sizes["FULLPHYSICS"] = mujoco.mj_stateSize(model, int(_FULL_STATE))
            sizes["INTEGRATION"] = mujoco.mj_stateSize(model, int(_ALL_STATE))
        if not states.ndim or states.shape[-1] not in sizes.values():
            known = ", ".join(f"{size} ({name})" for name, size in sizes.items())
            raise InvalidValueError(
                f"states of shape {states.shape} do not fit this model: their last axis must be "
                f"one of {known}"
            )
        self.numbers = states[..., states.shape[-1] - size :]  # they come last in each

    def get(self, parameter: str, address: int) -> Any:
        """Values of a parameter as they act.

        A stiffness that no model states is in the state from the first evaluation on, 0 before.
        """
        values = self.numbers[..., address]
        chosen = (values == 0.0) & (parameter == "axial_stiffness")
        return np.where(chosen, plugin.CHOSEN_STIFFNESS, values)[()]

    def set(self, name: str, address: int, value: Any) -> None:
        """Set ``<sheath>.<parameter>`` or ``<servo>.<gain>``, within its range."""
        try:
            values = np.asarray(value, np.float64)
        except (TypeError, ValueError, OverflowError):
            raise InvalidValueError(f"{name}: {value!r} is not a number, nor an array") from None
        owner, kind = name.rsplit(".", 1)
        for number in np.unique(values):
            if kind in LAW or (kind in plugin.PARAMETERS and number != 0.0):  # 0: not given
                check_in_range(plugin.PARAMETERS, kind, float(number), name)
            elif kind in plugin.GAINS:
                plugin.check_gain(kind, float(number), owner)
            elif not np.isfinite(number):
                raise InvalidValueError(f"{name} = {number} must be finite")
            elif kind == "radius" and number == 0.0:
                raise InvalidValueError(f"{name} = 0 [m] must be finite and not 0")
        shape = self.numbers.shape[:-1]
        try:
            values = np.broadcast_to(values, shape)
        except ValueError:
            raise InvalidValueError(
                f"{name}: values of shape {values.shape} are not of shape {shape}, one a state"
            ) from None
        if not self.numbers.flags.writeable:
            raise InvalidValueError(f"{name}: the array of the states is read-only")
        changed = bool(np.any(self.get(kind, address) != values))
        self.numbers[..., address] = values
        if kind == "axial_stiffness" and values.size:
            self._warn_of_step(name, owner, float(values.max()), changed)

    def _warn_of_step(self, name: str, sheath: str, stiffness: float, changed: bool) -> None:
        """Warn of an EA that the step does not carry."""
        instance = plugin.sheaths(self.model)[sheath]
        driven = "pretension" in plugin.unused_parameters(self.model, instance.instance)
        if driven and not changed:  # it may be one that was chosen
            return
        tendon = self.model.tendon(instance.tendon).id
        said = step_warning(self.model, tendon, stiffness, driven=driven)
        if said:
            warnings.warn(f"{name}: {said}", TendonWarning, stacklevel=4)


def _other_names(known: Mapping[str, plugin.Instance]) -> dict[str, str]:
    """Other name → name of a sheath: that of its tendon, and `sheath` for the only one."""
    names = {instance.tendon: name for name, instance in known.items()}
    if len(known) == 1:
        names.setdefault("sheath", next(iter(known)))
    return names


class Parameters(MutableMapping[str, Any]):
    """``<sheath>.<parameter>`` and ``<servo>.<gain>`` to value, live in `mjData.plugin_state`.

    Of the states of many simulations, values are arrays, one for each.

    A sheath goes by its name or by that of its tendon, in ``flexor.friction``, and the only one of
    a model by ``sheath``.

    A change acts from the next evaluation on; a reset brings back the model's values. The
    unstretched length follows from ``pretension`` at the first evaluation after a reset, so set
    that before it. Writing changes this data only, so that each of many simulations of one model
    can have its own friction.

    Parameters that a sheath has no use for are left out, such as the pretension of a tendon whose
    input tension a motor gives.

    Args:
        model: with sheaths.
        data: of that model; or an array (…, npluginstate), as ``bind("plugin_state")`` of
            `mujoco.batch` gives it, or of whole states, as `view_sheath` takes them.

    Raises:
        UnknownKeyError: no such sheath or parameter, with the nearest.
        UnusedKeyError: a parameter that the sheath has no use for, and why.
        InvalidValueError: a value that is not a number or outside its range; data of another model,
            of other numbers, that holds no states of sheaths, or that cannot be written.

    Warns:
        TendonWarning: of an axial stiffness that the time step does not resolve.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData | FloatArray) -> None:
        self._states = _States(model, data)
        known = plugin.sheaths(model)
        self._other_names = _other_names(known)
        for name, instance in known.items():  # which refuses numbers that are not of this model
            plugin.sheath_arrays(model, self._states.numbers, name, instance.state)
        self._unused = {
            f"{name}.{parameter}": why
            for name, instance in known.items()
            for parameter, why in plugin.unused_parameters(model, instance.instance).items()
        }
        self._address = {
            f"{name}.{parameter}": instance.state + k
            for name, instance in known.items()
            for k, parameter in enumerate(plugin.PARAMETERS)
            if f"{name}.{parameter}" not in self._unused
        } | {
            f"{name}.{gain}": state + k
            for name, state in plugin.servos(model).items()
            for k, gain in enumerate(plugin.GAINS)
            if gain not in _FIXED_GAINS
        }

    def _key(self, name: str) -> str:
        """A name with that of the sheath, where it has another of it."""
        owner, _, kind = str(name).rpartition(".")
        keys = (str(name), f"{self._other_names.get(owner, owner)}.{kind}")
        for key in keys:
            if key in self._unused:
                raise UnusedKeyError(f"{name} {self._unused[key]}")
            if key in self._address:
                return key
        raise UnknownKeyError("parameter", str(name), self._address)

    def __getitem__(self, name: str) -> Any:
        key = self._key(name)
        return self._states.get(key.rsplit(".", 1)[1], self._address[key])

    def __setitem__(self, name: str, value: Any) -> None:
        key = self._key(name)
        self._states.set(key, self._address[key], value)

    def __delitem__(self, name: str) -> None:
        raise InvalidValueError(f"{name} cannot be removed, only set")

    def __iter__(self) -> Iterator[str]:
        return iter(self._address)

    def __len__(self) -> int:
        return len(self._address)

    def __repr__(self) -> str:
        owners = ", ".join(dict.fromkeys(name.rpartition(".")[0] for name in self._address))
        return f"Parameters({len(self)} of {owners or 'no sheath'})"


class SheathView:
    """A sheath's quantities at the latest evaluation, and its parameters, live.

    Of the states of many simulations, every quantity has their axes first. The parameters of
    `Parameters` are attributes that can be set: ``view.friction = 0.2`` acts from the next
    evaluation on, in this data or in these states only. Setting one raises InvalidValueError where
    it is not a number, outside its range, or of no use to this sheath.

    Attributes:
        name: of the sheath.
        tendon: that runs in it.
    """

    __slots__ = ("_instance", "_states", "name", "tendon")
    _instance: Any
    _states: _States
    name: str
    tendon: str

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData | FloatArray, sheath: str
    ) -> None:
        known = plugin.sheaths(model)
        other_names = _other_names(known)
        name = sheath if sheath in known else other_names.get(sheath, "")
        if not name:
            raise UnknownNameError("sheath or sheathed tendon", sheath, {*known, *other_names})
        initialise: Callable[[str, Any], None] = super().__setattr__  # past the parameters
        initialise("_states", _States(model, data))
        initialise("_instance", known[name])
        initialise("name", name)
        initialise("tendon", known[name].tendon)

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
        arrays = self._read()
        unit = plugin.tension_units(arrays.state)
        return np.asarray(unit[..., None] * arrays.segments["tension"])

    @property
    def positions(self) -> FloatArray:
        """(…, n+2, 3) points of the path, input end first: its ends and the guides between [m]."""
        return np.array(self._read().path)

    @property
    def lengths(self) -> FloatArray:
        """(…, n+1) length of each segment of the path, with its share of arcs [m]."""
        return np.array(self._read().segments["length"])

    @property
    def bend_angle(self) -> FloatArray:
        """(…, n) bend at each guide, input side first [rad]."""
        return np.array(self._read().guides["angle"])

    @property
    def slip(self) -> FloatArray:
        """(…, n) +1 if tendon slides towards the input, −1 towards the output, 0 at rest."""
        guides = self._read().guides
        return np.where(guides["flow"] != 0.0, guides["slip"], 0.0)

    @property
    def friction_work(self) -> FloatArray:
        """(…, n) friction work at each guide since the reset [J]."""
        arrays = self._read()
        not_counted = arrays.state["has_trial"][..., None] != 0.0  # by a finished step
        guides = arrays.guides
        latest = np.where(not_counted, guides["trial_friction_work"], 0.0)
        return np.asarray(guides["friction_work"] + latest)

    @property
    def rebound(self) -> Any:
        """Number of times that the state was another model's, or empty, and was bound again."""
        return self._read().state["rebound"].astype(int)[()]

    @property
    def unsolved(self) -> Any:
        """Number of evaluations without a solution since the reset."""
        return self._read().state["unsolved"].astype(int)[()]

    def __getattr__(self, name: str) -> Any:
        values = self._states.get(name, self._find(name))
        if name == "axial_stiffness":  # none is stated
            return np.where(self._read().state["inextensible"] != 0.0, np.inf, values)[()]
        return values

    def __setattr__(self, name: str, value: Any) -> None:
        address, parameter = self._find(name), f"{self.name}.{name}"
        why = plugin.unused_parameters(self._states.model, self._instance.instance).get(name)
        if why:
            raise InvalidValueError(f"{parameter} {why}")
        self._states.set(parameter, address, value)

    def __dir__(self) -> list[str]:
        return sorted({*object.__dir__(self), *plugin.PARAMETERS})

    def __repr__(self) -> str:
        shape = self._states.numbers.shape[:-1]
        return f"SheathView({self.name!r} on tendon {self.tendon!r}, states {shape})"

    def _find(self, parameter: str) -> int:
        if parameter not in plugin.PARAMETERS:
            raise UnknownAttributeError(
                "parameter", parameter, plugin.PARAMETERS, f"sheath {self.name!r}"
            )
        return int(self._instance.state) + list(plugin.PARAMETERS).index(parameter)

    def _read(self) -> Any:
        states = self._states
        return plugin.sheath_arrays(states.model, states.numbers, self.name, self._instance.state)


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
