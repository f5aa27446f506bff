"""Device arrays of the sheaths of all worlds, to and from a simulation of MuJoCo."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from tendon_mj.warp.support import (
    LIVE_PARAMETERS,
    WITHOUT_PORT,
    Simulated,
    rows_of,
    state_field,
)
from tendon_mj.warp.tendons import ELASTIC, INEXTENSIBLE, WOUND, Tendons

# committed numbers of a sheath, by the names that the plugin has for them
COMMITTED: Final = (
    "wound_in",
    "wound_out",
    "spring_length",
    "spring_product",
    "constraint_force",
    "previous_constraint",
)
_STIFF = 1e6  # EA of a driven tendon where none is given [N]

# (rows, type, names) of arrays with a column for each world; rows of "all" segments and guides are
# those of inextensible tendons as well
_BY_WORLD = (
    ("sheaths", wp.bool, "started has_trial active yields"),
    ("sheaths", wp.float32, "trial_time"),
    ("sheaths", wp.float64, "wound_in wound_out trial_wound_in trial_wound_out"),
    ("sheaths", wp.float64, "reel_torque output_torque drive_bears spring_length spring_product"),
    ("sheaths", wp.float64, "trial_spring_length given_tension"),
    ("sheaths", wp.float64, "constraint_force previous_constraint solved_force"),
    ("all segments", wp.float64, "length pull"),
    ("all segments", wp.vec3, "start along"),
    ("all segments", wp.int32, "near_body far_body"),
    ("segments", wp.float64, "stored before tension give kept alone prefix"),
    ("all guides", wp.float64, "angle sliding_speed"),
    ("all guides", wp.bool, "is_on_arc"),
    ("guides", wp.float64, "shift flow constant dynamic_ratio"),
    ("guides", wp.float64, "input_ratio input_inverse output_ratio output_inverse"),
    ("guides", wp.int32, "previous_slip slip"),
    ("breakpoints", wp.float64, "breakpoint bend jump"),
    ("arcs", wp.bool, "touched trial_touches"),
    ("arcs", wp.vec3d, "near_tangent far_tangent trial_near trial_far"),
)
# and of arrays for users, a row for each world
_RESULTS = (
    ("all segments", wp.float32, "tension_out"),
    ("sheaths", wp.float32, "input_tension output_tension"),
    ("sheaths", wp.int32, "unsolved"),
)
_NUMPY = {wp.bool: np.bool_, wp.int32: np.int32, wp.float32: np.float32}


def allocate(
    simulated: dict[str, Simulated],
    reels: Sequence[tuple[int, int]],
    beyond: ArrayLike,
    nworld: int,
) -> Any:
    """Sheaths of all worlds, each as it is in the simulation.

    Args:
        simulated: each sheath by name.
        reels: addresses of the control and the output of each one's reel, −1 without one.
        beyond: by how much each one's length exceeds the rest length of its own spring [m].
        nworld: number of worlds.
    """
    tendons = Tendons()
    _describe(tendons, simulated, reels)
    tendons.beyond_spring = _array(beyond, wp.float64)
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
    for rows, kind, names in _BY_WORLD:
        for name in names.split():
            setattr(tendons, name, wp.zeros((counts[rows], nworld), dtype=kind))
    for rows, kind, names in _RESULTS:
        for name in names.split():
            setattr(tendons, name, wp.zeros((nworld, counts[rows]), dtype=kind))
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


def _array(values: Any, kind: Any) -> Any:
    return wp.array(np.asarray(values).astype(_NUMPY.get(kind, np.float64)), dtype=kind)


def _describe(
    tendons: Any, simulated: dict[str, Simulated], reels: Sequence[tuple[int, int]]
) -> None:
    """Set the description of each sheath."""
    guides, rows = np.array([len(s.guides) for s in simulated.values()]), rows_of(simulated)
    arcs, arc_guides = state_field(simulated, "arcs"), state_field(simulated, "arc_guides")
    inextensible = state_field(simulated, "inextensible") != 0.0
    driven = state_field(simulated, "driven") != 0.0
    stored_arcs = np.where(inextensible, 0, arcs)
    sharing = guides - arcs * arc_guides - state_field(simulated, "pulleys")
    order = np.argsort(rows.segment)
    for name, kind, values in (
        ("tendon", wp.int32, state_field(simulated, "tendon")),
        ("guides", wp.int32, guides),
        ("kind", wp.int32, np.where(inextensible, INEXTENSIBLE, np.where(driven, ELASTIC, WOUND))),
        ("first_guide", wp.int32, rows.guide),
        ("first_segment", wp.int32, rows.segment),
        ("first_shown", wp.int32, rows.shown),
        ("sheath", wp.int32, np.repeat(order, guides[order] + 1)),
        ("first_arc", wp.int32, np.cumsum(stored_arcs) - stored_arcs),
        ("arc_guides", wp.int32, arc_guides),
        ("inner_guides", wp.int32, state_field(simulated, "inner_guides")),
        ("sharing", wp.float64, np.maximum(1.0, sharing)),
        ("step", wp.int32, np.where(state_field(simulated, "input_at_last"), -1, 1)),
        ("constrained", wp.bool, state_field(simulated, "constrained")),
        ("own_spring", wp.bool, state_field(simulated, "own_spring")),
        ("reel", wp.int32, [control for control, _ in reels]),
        ("reel_output", wp.int32, [output for _, output in reels]),
        ("reel_joint", wp.int32, state_field(simulated, "reel_joint")),
        ("reel_radius", wp.float64, state_field(simulated, "reel_radius")),
        ("output_joint", wp.int32, state_field(simulated, "output_joint")),
        ("output_radius", wp.float64, state_field(simulated, "output_radius")),
    ):
        setattr(tendons, name, _array(values, kind))


def _fill_parameters(tendons: Any, simulated: dict[str, Simulated], nworld: int) -> None:
    """Give every world the parameters of the simulation."""
    for name in LIVE_PARAMETERS:
        values = np.array([float(sheath.state["law"][name]) for sheath in simulated.values()])
        if name == "axial_stiffness":
            values[values == 0.0] = _STIFF
        setattr(tendons, name, _array(np.tile(values, (nworld, 1)), wp.float32))


def _fill_state(tendons: Any, simulated: dict[str, Simulated], nworld: int) -> None:
    """Give every world the committed state of the simulation."""

    def put(name: str, kind: Any, rows: NDArray[Any]) -> None:
        if len(rows):
            columns = np.repeat(rows[:, None], nworld, axis=1)
            setattr(tendons, name, _array(columns, kind))

    for name in COMMITTED:
        put(name, wp.float64, state_field(simulated, name))
    started, finished = state_field(simulated, "started"), state_field(simulated, "finished")
    inextensible = state_field(simulated, "inextensible") != 0.0
    put("started", wp.bool, np.where(inextensible, finished, started))
    elastic = elastic_of(simulated)
    for name, field in (("stored", "stored"), ("before", "previous_tension")):
        rows = [np.ravel(sheath.segments[field]) for sheath in elastic]
        put(name, wp.float64, np.concatenate([*rows, []]))
    speeds = np.zeros(sum(len(sheath.guides) for sheath in simulated.values()))
    for sheath, row in zip(simulated.values(), rows_of(simulated).guide, strict=True):
        speeds[row : row + len(sheath.guides)] = sheath.guides["sliding_speed"]
    put("sliding_speed", wp.float64, speeds)
    slips = [np.ravel(sheath.guides["previous_slip"]) for sheath in elastic]
    put("previous_slip", wp.int32, np.concatenate([*slips, []]))
    if any(len(sheath.arcs) for sheath in elastic):
        arcs = np.concatenate([sheath.arcs for sheath in elastic])
        put("touched", wp.bool, arcs["touches"])
        for name, end in (("near_tangent", "1"), ("far_tangent", "2")):
            points = np.stack([arcs[axis + end] for axis in "xyz"], axis=-1)
            put(name, wp.vec3d, points)


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
        tau, give = column("before")[here], column("give")[here]
        sheath.segments["previous_tension"] = tau
        # the plugin's guides have yielded by now
        sheath.segments["stored"] = column("stored")[here] + give * tau / (1.0 + tau)
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
