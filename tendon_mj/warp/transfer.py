"""Device arrays of the sheaths of all worlds, to and from a simulation of MuJoCo."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, Final

import mujoco
import numpy as np
import warp as wp
from numpy.typing import NDArray

from tendon_mj.plugin import C
from tendon_mj.warp.support import (
    LIVE_PARAMETERS,
    WITHOUT_PORT,
    Simulated,
    rows_of,
    simulated_sheaths,
    state_field,
)
from tendon_mj.warp.tendons import ELASTIC, INEXTENSIBLE, WOUND, Tendons

# committed numbers of a sheath, by the names that the plugin has for them
COMMITTED: Final = (
    "wound_in",
    "wound_out",
    "laid_pretension",
    "spring_length",
    "spring_product",
    "constraint_force",
    "previous_constraint",
)
_STIFF = 1e6  # EA of a driven tendon where none is given [N]

# rows → names of arrays with a column for each world; rows of "all" segments and guides are those
# of inextensible tendons as well
_BY_WORLD = {
    "sheaths": "started has_trial active trial_time wound_in wound_out"
    " laid_pretension trial_wound_in trial_wound_out reel_torque output_torque drive_bears"
    " spring_length spring_product trial_spring_length given_tension constraint_force"
    " previous_constraint solved_force",
    "all segments": "length pull start along near_body far_body",
    "segments": "stored before tension give kept alone prefix",
    "all guides": "angle sliding_speed is_on_arc",
    "guides": "shift flow constant dynamic_ratio input_ratio input_inverse output_ratio"
    " output_inverse previous_slip slip",
    "breakpoints": "breakpoint bend jump",
    "arcs": "touched trial_touches near_tangent far_tangent trial_near trial_far",
}
# and of arrays for users, a row for each world
_RESULTS = {"all segments": "tension_out", "sheaths": "input_tension output_tension unsolved"}


def put_zeros(struct: Any, made: Any, names: str, shape: tuple[int, ...]) -> None:
    """Set arrays of a struct on the device to zeros, in the types that it declares."""
    for name in names.split():
        setattr(made, name, wp.zeros(shape, dtype=struct.vars[name].type.dtype))


def put(struct: Any, made: Any, arrays: Mapping[str, Any]) -> None:
    """Set arrays of a struct on the device to these values, in the types that it declares."""
    for name, values in arrays.items():
        dtype = struct.vars[name].type.dtype
        scalar = wp.dtype_to_numpy(getattr(dtype, "_wp_scalar_type_", dtype))
        setattr(made, name, wp.array(np.asarray(values).astype(scalar), dtype=dtype))


def in_each_world(rows: Any, nworld: int) -> NDArray[Any]:
    """Rows with a column for each world, all alike."""
    return np.repeat(np.asarray(rows)[:, None], nworld, axis=1)


def allocate(model: mujoco.MjModel, simulated: dict[str, Simulated], nworld: int) -> Any:
    """Sheaths of all worlds, each as it is in the simulation by its name."""
    tendons = Tendons()
    _describe(tendons, model, simulated)
    elastic = elastic_of(simulated)
    counts = {
        "all segments": sum(len(sheath.segments) for sheath in simulated.values()),
        "all guides": sum(len(sheath.guides) for sheath in simulated.values()),
        "segments": sum(len(sheath.segments) for sheath in elastic),
        "guides": sum(len(sheath.guides) for sheath in elastic),
        "arcs": sum(len(sheath.arcs) for sheath in elastic),
        "sheaths": len(simulated),
    }
    counts["breakpoints"] = 2 * counts["guides"]
    for rows, names in _BY_WORLD.items():
        put_zeros(Tendons, tendons, names, (counts[rows], nworld))
    for rows, names in _RESULTS.items():
        put_zeros(Tendons, tendons, names, (nworld, counts[rows]))
    _fill_parameters(tendons, simulated, nworld)
    _fill_state(tendons, simulated, nworld)
    return tendons


def elastic_of(simulated: dict[str, Simulated]) -> list[Simulated]:
    """Sheaths of the tendons whose segments store length."""
    return [sheath for sheath in simulated.values() if not sheath.state["inextensible"]]


def inextensible_of(simulated: dict[str, Simulated]) -> dict[int, Simulated]:
    """Index of each other sheath to the sheath."""
    each = enumerate(simulated.values())
    return {k: sheath for k, sheath in each if sheath.state["inextensible"]}


def _addresses(model: mujoco.MjModel, reel: int) -> tuple[int, int]:
    """Of a reel's control and output; −1 without a reel, for the output also if it is disabled."""
    if reel < 0:
        return -1, -1
    disabled = C.mj_actuatorDisabled(model._address, reel)
    return int(model.actuator_ctrladr[reel]), -1 if disabled else int(model.actuator_outadr[reel])


def _beyond_spring(model: mujoco.MjModel) -> list[float]:
    """Unstretched length of each sheath less the rest length of its own spring [m]."""
    beyond = []
    for sheath in simulated_sheaths(model, mujoco.MjData(model)).values():
        state, law = sheath.state, sheath.state["law"]
        if state["own_spring"]:
            length = float(model.tendon_length0[int(state["tendon"])]) + float(law["slack"])
            strain = float(law["pretension"]) / float(law["axial_stiffness"])
            beyond.append(length / (1.0 + strain) - float(state["spring_length"]))
        else:
            beyond.append(0.0)
    return beyond


def _describe(tendons: Any, model: mujoco.MjModel, simulated: dict[str, Simulated]) -> None:
    """Set the description of each sheath."""
    reels = [_addresses(model, int(reel)) for reel in state_field(simulated, "reel_actuator")]
    guides, rows = np.array([len(s.guides) for s in simulated.values()]), rows_of(simulated)
    arcs, arc_guides = state_field(simulated, "arcs"), state_field(simulated, "arc_guides")
    inextensible = state_field(simulated, "inextensible") != 0.0
    driven = state_field(simulated, "driven") != 0.0
    stored_arcs = np.where(inextensible, 0, arcs)
    sharing = guides - arcs * arc_guides - state_field(simulated, "pulleys")
    order = np.argsort(rows.segment)
    described = {
        "tendon": state_field(simulated, "tendon"),
        "guides": guides,
        "kind": np.where(inextensible, INEXTENSIBLE, np.where(driven, ELASTIC, WOUND)),
        "first_guide": rows.guide,
        "first_segment": rows.segment,
        "first_shown": rows.shown,
        "sheath": np.repeat(order, guides[order] + 1),
        "first_arc": np.cumsum(stored_arcs) - stored_arcs,
        "arc_guides": arc_guides,
        "inner_guides": state_field(simulated, "inner_guides"),
        "sharing": np.maximum(1.0, sharing),
        "step": np.where(state_field(simulated, "input_at_last"), -1, 1),
        "constrained": state_field(simulated, "constrained"),
        "own_spring": state_field(simulated, "own_spring"),
        "beyond_spring": _beyond_spring(model),
        "reel": [control for control, _ in reels],
        "reel_output": [output for _, output in reels],
        "reel_joint": state_field(simulated, "reel_joint"),
        "reel_radius": state_field(simulated, "reel_radius"),
        "output_joint": state_field(simulated, "output_joint"),
        "output_radius": state_field(simulated, "output_radius"),
    }
    put(Tendons, tendons, described)


def _fill_parameters(tendons: Any, simulated: dict[str, Simulated], nworld: int) -> None:
    """Give every world the parameters of the simulation."""
    for name in LIVE_PARAMETERS:
        values = np.array([float(sheath.state["law"][name]) for sheath in simulated.values()])
        if name == "axial_stiffness":
            values[values == 0.0] = _STIFF
        put(Tendons, tendons, {name: np.tile(values, (nworld, 1))})


def _fill_state(tendons: Any, simulated: dict[str, Simulated], nworld: int) -> None:
    """Give every world the committed state of the simulation."""

    rows: dict[str, Any] = {name: state_field(simulated, name) for name in COMMITTED}
    started, finished = state_field(simulated, "started"), state_field(simulated, "finished")
    inextensible = state_field(simulated, "inextensible") != 0.0
    rows["started"] = np.where(inextensible, finished, started)
    elastic = elastic_of(simulated)
    for name, field in (("stored", "stored"), ("before", "previous_tension")):
        each = [np.ravel(sheath.segments[field]) for sheath in elastic]
        rows[name] = np.concatenate([*each, []])
    speeds = np.zeros(sum(len(sheath.guides) for sheath in simulated.values()))
    for sheath, row in zip(simulated.values(), rows_of(simulated).guide, strict=True):
        speeds[row : row + len(sheath.guides)] = sheath.guides["sliding_speed"]
    rows["sliding_speed"] = speeds
    slips = [np.ravel(sheath.guides["previous_slip"]) for sheath in elastic]
    rows["previous_slip"] = np.concatenate([*slips, []])
    if any(len(sheath.arcs) for sheath in elastic):
        arcs = np.concatenate([sheath.arcs for sheath in elastic])
        rows["touched"] = arcs["touches"]
        for name, end in (("near_tangent", "1"), ("far_tangent", "2")):
            rows[name] = np.stack([arcs[axis + end] for axis in "xyz"], axis=-1)
    filled = {name: in_each_world(values, nworld) for name, values in rows.items() if len(values)}
    put(Tendons, tendons, filled)


def read_back(simulated: dict[str, Simulated], tendons: Any, world: int, last: float) -> None:
    """Write parameters and committed state of a world, as `allocate` takes them.

    That of groups is left out.

    Args:
        simulated: sheaths of the simulation by name, in the order that they have on the device.
        tendons: on the device.
        world: number of it.
        last: when its last step began [s].
    """

    @functools.cache  # an array is copied from the device once
    def column(name: str) -> Any:
        return getattr(tendons, name).numpy()[:, world]

    parameters = {name: getattr(tendons, name).numpy()[world] for name in LIVE_PARAMETERS}
    segment, guide, arc, rows = 0, 0, 0, rows_of(simulated).guide
    for k, sheath in enumerate(simulated.values()):
        law = sheath.state["law"]
        for name, values in parameters.items():
            # of those that are as they were, all digits
            if np.float32(law[name]) != values[k] and not _is_default(name, law[name]):
                law[name] = values[k]
        for name in WITHOUT_PORT:
            law[name] = 0.0
        for name in (*COMMITTED, "started"):
            sheath.state[name] = column(name)[k]
        sheath.state["finished"] = sheath.state["started"]
        sheath.state["commit_time"], sheath.state["has_trial"] = last, 0.0
        guides = slice(rows[k], rows[k] + len(sheath.guides))
        sheath.guides["sliding_speed"] = column("sliding_speed")[guides]
        sheath.state["speed_kept"] = law["stribeck_friction"] > 0.0
        sheath.state["unsolved"] = tendons.unsolved.numpy()[world, k]
        if sheath.state["inextensible"]:
            continue
        here = slice(segment, segment := segment + len(sheath.segments))
        sheath.segments["previous_tension"] = column("before")[here]
        sheath.segments["stored"] = column("stored")[here]
        here = slice(guide, guide := guide + len(sheath.guides))
        sheath.guides["previous_slip"] = column("previous_slip")[here]
        here = slice(arc, arc := arc + len(sheath.arcs))
        if len(sheath.arcs):
            sheath.arcs["touches"] = column("touched")[here]
            for end, name in (("1", "near_tangent"), ("2", "far_tangent")):
                for axis, values in zip("xyz", column(name)[here].T, strict=True):
                    sheath.arcs[axis + end] = values


def _is_default(name: str, value: float) -> bool:
    return name == "axial_stiffness" and value == 0.0
