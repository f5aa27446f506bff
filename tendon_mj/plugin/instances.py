"""Sheaths and servos of a model, and where in `mjData.plugin_state` each keeps its state."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin.abi import attribute_of, plugin_at
from tendon_mj.plugin.compiled_checks import (
    DRAWN,
    ELASTICITY,
    GIVEN,
    NOT_DRAWN,
    OF_A_DRUM,
    OF_A_PATH,
    OF_A_REEL,
)
from tendon_mj.plugin.force_servo_plugin import SERVO
from tendon_mj.plugin.sheath_plugin import NAME, PARAMETERS, STATE, View, attachment, size_of
from tendon_mj.plugin.sheath_plugin import view as sheath_view

# group of tendons that stand for cables without a path, and of their sites: viewers hide it
UNDRAWN = mujoco.mjNGROUP - 1
_INEXTENSIBLE = (
    "has no meaning where tendon {} does not stretch: give it axial_stiffness in the model"
)


class Instance(NamedTuple):
    """A sheath of a model."""

    tendon: str
    state: int  # address of its first number in `mjData.plugin_state`
    instance: int  # of its plugin


class Branch(NamedTuple):
    """A part of a tendon between two pulleys."""

    number: int  # along the path, from 0
    first: int  # segment at its input
    last: int  # segment at its output
    words: str  # that follow the tendon's name, such as ", branch 1"


ALL_OF_IT = Branch(0, 0, -1, "")  # of a tendon without pulleys


def sheaths(model: mujoco.MjModel) -> dict[str, Instance]:
    """Every sheath of a model by name; an unnamed one goes by its tendon's name."""
    named = {}
    for k in range(model.nplugin):
        if _is_of(model, k, NAME) and not attribute_of(model._address, k, "sensor"):
            tendon = _tendon_name(model, attachment(model._address, k).tendon)
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_PLUGIN, k) or tendon
            named[name] = Instance(tendon, int(model.plugin_stateadr[k]), k)
    return named


def _sheath(model: mujoco.MjModel, name: str) -> Instance:
    """A sheath by its name."""
    known = sheaths(model)
    if name not in known:
        raise UnknownNameError("sheath", name, known)
    return known[name]


def _tendon_name(model: mujoco.MjModel, tendon: float) -> str:
    """Name of a tendon; empty without one, as in a binary model that another release wrote."""
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, int(tendon)) or ""


def sensor_kind(model: mujoco.MjModel, sensor: int) -> str:
    """Kind of a sheath's sensor, one of `KINDS`; empty for any other sensor."""
    instance = int(model.sensor_plugin[sensor])
    return attribute_of(model._address, instance, "sensor") if _is_of(model, instance, NAME) else ""


def servos(model: mujoco.MjModel) -> dict[str, int]:
    """If the state of every servo begins, by its name or else by its actuator's."""
    named = {}
    for k in range(model.nplugin):
        if _is_of(model, k, SERVO):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_PLUGIN, k)
            for actuator in np.flatnonzero(model.actuator_plugin == k):
                name = name or model.actuator(int(actuator)).name
            if name:
                named[name] = int(model.plugin_stateadr[k])
    return named


def _is_of(model: mujoco.MjModel, instance: int, plugin: str) -> bool:
    return instance >= 0 and plugin_at(model.plugin[instance]) == plugin


def unused_parameters(model: mujoco.MjModel, instance: int) -> dict[str, str]:
    """Parameters that a sheath has no use for, whatever their values, and why each has none."""
    bound = attachment(model._address, instance)
    name = repr(_tendon_name(model, bound.tendon))
    unused = {
        parameter: f"has no meaning without {end}_joint"
        for end, joint in (("reel", bound.reel_joint), ("output", bound.output_joint))
        for parameter in PARAMETERS
        if joint < 0.0 and parameter.startswith(f"{end}_")
    }
    if bound.fixed:
        return unused | dict.fromkeys((*OF_A_PATH, "creep_time"), NOT_DRAWN.format(name))
    unused |= dict.fromkeys(OF_A_DRUM, DRAWN)
    if bound.driven:
        unused |= dict.fromkeys(OF_A_REEL, GIVEN.format(name))
        if bound.inextensible:
            unused |= dict.fromkeys((*ELASTICITY, "creep_time"), _INEXTENSIBLE.format(name))
    return unused


def unsolved_evaluations(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, int]:
    """Evaluations without a solution since the reset, of every sheath by name."""
    return {
        name: int(sheath_view(data.plugin_state, sheath.state).state.unsolved)
        for name, sheath in sheaths(model).items()
    }


def segment_tensions(
    model: mujoco.MjModel, data: mujoco.MjData, sheath: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The path of a sheath's tendon and the tension along it, at the latest evaluation.

    Returns:
        (n+2, 3) points [m], NaN of a fixed tendon, which has no path; and (n+1,) tensions of the
        segments between them [N].

    Raises:
        UnknownNameError: no such sheath.
    """
    state, segments, _, path = sheath_view(data.plugin_state, _sheath(model, sheath).state)
    points = np.where(state.fixed != 0.0, np.nan, path)
    return points, tension_units(state) * segments["tension"]


def tension_units(states: Any) -> Any:
    """Tension that τ = 1 stands for in states of a sheath [N], as `tension_unit` has it."""
    return np.where(states["inextensible"] != 0.0, 1.0, states["law"]["axial_stiffness"])


def tension_path(
    model: mujoco.MjModel, data: mujoco.MjData, sheath: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The path of a sheath's tendon to draw, as `segment_tensions` but with both ends of each arc.

    Returns:
        (m+1, 3) points [m], and (m,) tensions between them [N]: the mean of its neighbours on the
        chord of an arc, NaN if no tendon is, from one branch to the next.

    Raises:
        UnknownNameError: no such sheath.
    """
    points, tensions = segment_tensions(model, data, sheath)
    instance = _sheath(model, sheath)
    state, segments, guides, _ = sheath_view(data.plugin_state, instance.state)
    if state.arcs == 0.0 and state.pulleys == 0.0:
        return points, tensions
    tendon = model.tendon(instance.tendon).id
    start, count = data.ten_wrapadr[tendon], data.ten_wrapnum[tendon]
    wraps = data.wrap_xpos.reshape(-1, 3)[start : start + count]
    ends = np.repeat(points[:-1, None], 2, axis=1)
    straight = (segments["point"] >= 0.0) & (segments["point"] < count - 1)
    near = int(state.input_at_last)
    spans = segments["point"][straight].astype(int)
    ends[straight] = np.stack([wraps[spans + near], wraps[spans + 1 - near]], axis=1)
    known = np.flatnonzero(straight)
    # next to an end may be a geom that the tendon does not touch
    ends[: known[0]], ends[known[-1] + 1 :] = ends[known[0], 0], ends[known[-1], 1]
    for before, after in itertools.pairwise(known):  # the segments on an arc share its chord
        a, b, between = ends[before, 1], ends[after, 0], after - before
        for j in range(before + 1, after):
            shares = (j - before + np.array([-0.5, 0.5])) / between
            ends[j] = a + shares[:, None] * (b - a)
    chords = 0.5 * (tensions[:-1] + tensions[1:])
    chords[guides["is_pulley"] != 0.0] = np.nan
    drawn = np.insert(tensions, np.arange(1, len(tensions)), chords)
    return ends.reshape(-1, 3), drawn


def most_bent_branch(model: mujoco.MjModel, sheath: str) -> Branch:
    """The branch that bends most at `qpos0`, and so loses most: views and clips show its ends.

    Raises:
        UnknownNameError: no such sheath.
    """
    instance = _sheath(model, sheath)
    tendon = model.tendon(instance.tendon).id
    path = model.wrap_type[model.tendon_adr[tendon] :][: model.tendon_num[tendon]]
    if mujoco.mjtWrap.mjWRAP_PULLEY.value not in path:
        return ALL_OF_IT
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    guides = sheath_view(data.plugin_state, instance.state).guides
    pulleys = np.flatnonzero(guides["is_pulley"]).tolist()
    spans = list(zip([0, *(k + 1 for k in pulleys)], [*pulleys, len(guides)], strict=True))
    number = int(np.argmax([guides["angle"][first:last].sum() for first, last in spans]))
    return Branch(number, *spans[number], f", branch {number + 1}")


def sheath_arrays(
    model: mujoco.MjModel, plugin_states: NDArray[np.float64], sheath: str, start: int
) -> View:
    """State of a sheath in many simulations at once, their axes before those of `View`.

    Args:
        model: that has the sheath.
        plugin_states: (..., npluginstate).
        sheath: its name.
        start: address of its first number in `mjData.plugin_state`, see `Instance`.

    Raises:
        InvalidValueError: the numbers are not states of this model.
    """
    states = np.ascontiguousarray(plugin_states, np.float64)
    scalars: NDArray[np.void] = states[..., start : start + STATE.itemsize // 8].view(STATE)
    counts: NDArray[np.float64] = scalars["guides"]
    n = int(counts.flat[0]) if counts.size and np.isfinite(counts).all() else -1
    state_size = int(model.plugin_statenum[np.flatnonzero(model.plugin_stateadr == start)].max())
    bound = (scalars["config_signature"] != 0.0).all()  # as a reset leaves it
    if not bound or n < 0 or (counts != n).any() or size_of(n, 0, 0) > state_size:
        raise InvalidValueError(
            f"sheath {sheath!r}: these are no plugin states of this model, or none at all"
        )
    return sheath_view(states, start)
