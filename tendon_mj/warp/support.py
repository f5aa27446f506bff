"""The sheaths of a simulation of MuJoCo, and the features that MuJoCo Warp can simulate.

A feature that is not supported is refused by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import mujoco
import mujoco_warp as mjw
import numpy as np

from tendon_mj.errors import NoPluginsError
from tendon_mj.plugin import sensor_kind, servos, sheath_arrays, sheaths
from tendon_mj.sheath import ARC, LAW
from tendon_mj.warp.reactions import FORCE, TORQUE

SheathLayouts = tuple[tuple[str | int, ...], ...]
# live parameters that each world has of its own, by the names that the plugin has for them
LIVE_PARAMETERS: Final = (
    "axial_stiffness",
    "friction",
    "static_friction",
    "constant_friction",
    "pretension",
    "extra_bend",
    "slack",
    "backlash",
    "stribeck_friction",
    "stribeck_velocity",
)
_SCALES = {parameter.scale for parameter in LAW.values()}  # of no effect by themselves
# parameters of effects that no world has
WITHOUT_PORT: Final = tuple(effect for effect in LAW if effect not in {*LIVE_PARAMETERS, *_SCALES})
_INTEGRATORS = (
    mujoco.mjtIntegrator.mjINT_EULER,
    mujoco.mjtIntegrator.mjINT_IMPLICIT,
    mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
)
_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value
_SENSORS_OFF = mujoco.mjtDisableBit.mjDSBL_SENSOR.value
_PASSIVE_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value | mujoco.mjtDisableBit.mjDSBL_DAMPER.value


class Simulated(NamedTuple):
    """State of one sheath; records with the fields that `tendon_mj.sheath.records` has."""

    state: Any  # scalars of the plugin, with its parameters in `law`
    segments: Any  # (n+1,)
    guides: Any  # (n,)
    arcs: Any  # (arcs,)
    unknown: Any  # (dofs,) of the first sheath of a model, forces that friction did not know
    last: Any  # (dofs,) of the same, acceleration of the last step


def simulated_sheaths(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, Simulated]:
    """Every sheath of a simulation by name."""
    simulated = {}
    plugin_state = data.plugin_state
    begin = plugin_state.__array_interface__["data"][0]
    for name, instance in sheaths(model).items():
        state, segments, guides, path = sheath_arrays(model, plugin_state, name, instance.state)
        behind = (path.__array_interface__["data"][0] - begin) // 8 + path.size
        count = int(state["arcs"])
        after = behind + count * ARC.itemsize // 8
        arcs = plugin_state[behind:after].view(ARC)
        unknown, _, last = plugin_state[after : after + 3 * int(state["dofs"])].reshape(3, -1)
        simulated[name] = Simulated(state, segments, guides, arcs, unknown, last)
    return simulated


class Rows(NamedTuple):
    """First rows of the sheaths: in what is shown, of segments, and of guides; in all arrays."""

    shown: list[int]
    segment: list[int]
    guide: list[int]


def rows_of(simulated: Mapping[str, Simulated]) -> Rows:
    """Rows of each sheath; those of inextensible tendons come last, but in what is shown."""
    guides = np.array([len(sheath.guides) for sheath in simulated.values()])
    order = np.argsort([bool(s.state["inextensible"]) for s in simulated.values()], kind="stable")
    first = np.empty(len(guides), int)
    first[order] = np.cumsum(guides[order]) - guides[order]
    before = np.empty(len(guides), int)
    before[order] = np.arange(len(guides))
    shown = np.cumsum(guides + 1) - guides - 1
    return Rows(shown.tolist(), (first + before).tolist(), first.tolist())


def layout_of(simulated: dict[str, Simulated]) -> SheathLayouts:
    """Layout of each sheath, by which kernels find its numbers; another model has another."""
    whole = ("tendon", "driven", "inextensible", "reel_actuator", "reel_joint", "output_joint")
    return tuple(
        (
            name,
            *(int(sheath.state[field]) for field in (*whole, "input_at_last")),
            *(len(part) for part in (sheath.segments, sheath.guides, sheath.arcs)),
        )
        for name, sheath in simulated.items()
    )


def state_field(simulated: dict[str, Simulated], field: str) -> np.ndarray[Any, Any]:
    """A scalar of each sheath."""
    return np.array([float(sheath.state[field]) for sheath in simulated.values()])


COUNTS_TENDONS = tuple(int(part) for part in mjw.__version__.split(".")[:2]) >= (3, 14)


def check_supported(model: mujoco.MjModel, sheaths: Mapping[str, Simulated]) -> None:
    """Refuse a model with features that are not supported.

    Args:
        model: with sheaths.
        sheaths: each by name.

    Raises:
        NoPluginsError: names it, its place, and a remedy.
    """
    for servo in servos(model):
        _refuse(f"servo {servo!r}", "put its law into your policy or into the control")
    check_options(model.opt, any(sheath.state["constrained"] for sheath in sheaths.values()))
    for geom in np.flatnonzero(model.geom_plugin >= 0):
        _refuse(f"geom {model.geom(geom).name!r} of another plugin", "take a mesh or a primitive")
    for sensor in range(model.nsensor):
        name = f"sensor {model.sensor(sensor).name!r}"
        if sensor_kind(model, sensor) == "friction_work":
            _refuse(f"{name} of friction_work", "remove it")
        if model.sensor_type[sensor] in (FORCE, TORQUE) and not COUNTS_TENDONS:
            _refuse(f"{name}, in which MuJoCo Warp before 3.14 counts no tendon", "upgrade it")
        if model.sensor_type[sensor] in (FORCE, TORQUE) and model.sensor_history[sensor, 0] > 0:
            _refuse(f"{name} with a history", "delay its reading yourself")
    check_sheaths(model, sheaths)


def check_options(options: Any, constrained: bool = False) -> None:
    """Refuse options that are not supported, of a model here or on the device.

    Args:
        options: of either.
        constrained: whether equalities or limits pull a tendon.

    Raises:
        NoPluginsError: names the option, and a remedy.
    """
    integrator = mujoco.mjtIntegrator(int(options.integrator))
    if integrator not in _INTEGRATORS:
        name = integrator.name.removeprefix("mjINT_")
        _refuse(f"integrator {name}", "take Euler, implicit or implicitfast")
    if int(options.enableflags) & mujoco.mjtEnableBit.mjENBL_SLEEP.value:
        _refuse("the flag sleep, for bodies of which some have tendons in sheaths", "disable it")
    if int(options.disableflags) & _PASSIVE_OFF == _PASSIVE_OFF:
        _refuse("disabling springs and dampers both", "disable one of them at most")
    if int(options.disableflags) & _SENSORS_OFF:  # in their stage constraints are read
        if constrained:
            _refuse(
                "disabling sensors where a constraint pulls a tendon in a sheath", "enable them"
            )
        if getattr(options, "run_rne_postconstraint", False):
            _refuse("run_rne_postconstraint without sensors", "enable sensors")


def check_sheaths(model: mujoco.MjModel, sheaths: Mapping[str, Simulated]) -> None:
    """Refuse unsupported features of sheaths, in the model or by their live parameters.

    Raises:
        NoPluginsError: names it, its place, and a remedy.
    """
    for name, sheath in sheaths.items():
        _check_sheath(model, f"sheath {name!r}: ", sheath)


def _check_sheath(model: mujoco.MjModel, where: str, sheath: Simulated) -> None:
    state = sheath.state
    tendon = int(state["tendon"])
    if state["fixed"]:
        _refuse(f"{where}a cable drive, on a fixed tendon", "draw its cable as a spatial tendon")
    for effect in WITHOUT_PORT:
        value = float(state["law"][effect])
        if value != 0.0:
            _refuse(f"{where}{effect} = {value:g} [{LAW[effect].unit}]", "set it to 0")
    for play in ("reel_play", "output_play"):
        if state[play] > 0.0:
            _refuse(f"{where}{play} = {state[play]:g}", "set it to 0")
    if state["pulleys"] and not state["inextensible"]:
        _refuse(f"{where}an elastic tendon that branches at a pulley", "state no elasticity")
    for kind, acts in (("stiffness", "own_spring"), ("stiffness", "driven"), ("damping", "driven")):
        if state[acts] and np.any(getattr(model, f"tendon_{kind}poly")[tendon]):
            _refuse(f"{where}a polynomial {kind} of its tendon", "give it a linear one")
    if not state["driven"]:
        reel = int(state["reel_actuator"])
        if reel >= 0 and model.actuator_delay[reel] > 0.0:
            _refuse(f"{where}a reel with a delay", "delay the control yourself")
        return
    on = (model.actuator_trntype == _TENDON) & (model.actuator_trnid[:, 0] == tendon)
    if np.any(model.actuator_dampingpoly[on]):
        _refuse(f"{where}a polynomial damping of its actuator", "give it a linear one")


def _refuse(feature: str, remedy: str) -> None:
    raise NoPluginsError(
        f"{feature}: tendon_mj.warp does not support this; {remedy}, or simulate the model with "
        "mujoco.mj_step, or many at once with mujoco.rollout"
    )
