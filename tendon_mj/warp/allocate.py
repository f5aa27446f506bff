"""Device arrays of the sheaths of all worlds, filled from a simulation of MuJoCo's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from tendon_mj.warp.simulated import Simulated, state_field
from tendon_mj.warp.support import PARAMETERS
from tendon_mj.warp.tendons import Tendons

# committed numbers of a sheath, by the names that the plugin has for them
COMMITTED: Final = (
    "wound_in",
    "wound_out",
    "spring_length",
    "spring_product",
    "constraint_force",
)
_STIFF = 1e6  # EA of a driven tendon where none is given [N]

# (rows, type, names) of what has a row each and a column for each world
_BY_WORLD = (
    ("sheaths", wp.bool, "started has_trial"),
    ("sheaths", wp.float32, "trial_time"),
    ("sheaths", wp.float64, "wound_in wound_out trial_wound_in trial_wound_out"),
    ("sheaths", wp.float64, "reel_torque output_torque spring_length spring_product"),
    ("sheaths", wp.float64, "trial_spring_length constraint_force solved_force"),
    ("segments", wp.float64, "stored before tension length give kept prefix pull"),
    ("segments", wp.int32, "point near_body far_body"),
    ("guides", wp.float64, "shift flow angle constant static_ratio dynamic_ratio"),
    ("guides", wp.float64, "input_ratio output_ratio"),
    ("guides", wp.int32, "previous_slip slip"),
    ("guides", wp.bool, "is_on_arc"),
    ("arcs", wp.bool, "touched trial_touches"),
    ("arcs", wp.vec3d, "near_tangent far_tangent trial_near trial_far"),
)
# and of what users read, a row for each world
_RESULTS = (
    ("segments", wp.float32, "tension_out"),
    ("sheaths", wp.float32, "input_tension output_tension"),
    ("sheaths", wp.int32, "unsolved"),
)
_NUMPY = {wp.bool: np.bool_, wp.int32: np.int32, wp.float32: np.float32}


def allocate(
    found: dict[str, Simulated], reels: Sequence[int], beyond: ArrayLike, nworld: int
) -> Any:
    """Sheaths of all worlds, each as it is in the simulation.

    Args:
        found: each sheath by name.
        reels: address of the control of each one's reel, −1 without one.
        beyond: by how much each one's length exceeds the rest length of its own spring [m].
        nworld: number of worlds.
    """
    tendons = Tendons()
    _describe(tendons, found, reels)
    tendons.beyond_spring = _array(beyond, wp.float64)
    counts = {
        "segments": sum(len(sheath.segments) for sheath in found.values()),
        "guides": sum(len(sheath.guides) for sheath in found.values()),
        "arcs": sum(len(sheath.arcs) for sheath in found.values()),
        "sheaths": len(found),
    }
    for rows, kind, names in _BY_WORLD:
        for name in names.split():
            setattr(tendons, name, wp.zeros((counts[rows], nworld), dtype=kind))
    for rows, kind, names in _RESULTS:
        for name in names.split():
            setattr(tendons, name, wp.zeros((nworld, counts[rows]), dtype=kind))
    _fill_parameters(tendons, found, nworld)
    _fill_state(tendons, found, nworld)
    return tendons


def _array(values: Any, kind: Any) -> Any:
    return wp.array(np.asarray(values).astype(_NUMPY.get(kind, np.float64)), dtype=kind)


def _describe(tendons: Any, found: dict[str, Simulated], reels: Sequence[int]) -> None:
    """Say what each sheath is."""
    guides = np.array([len(sheath.guides) for sheath in found.values()])
    arcs, arc_guides = state_field(found, "arcs"), state_field(found, "arc_guides")
    for name, kind, values in (
        ("tendon", wp.int32, state_field(found, "tendon")),
        ("guides", wp.int32, guides),
        ("first_guide", wp.int32, np.cumsum(guides) - guides),
        ("first_segment", wp.int32, np.cumsum(guides + 1) - guides - 1),
        ("first_arc", wp.int32, np.cumsum(arcs) - arcs),
        ("arc_guides", wp.int32, arc_guides),
        ("inner_guides", wp.int32, state_field(found, "inner_guides")),
        ("sharing", wp.float64, np.maximum(1.0, guides - arcs * arc_guides)),
        ("step", wp.int32, np.where(state_field(found, "input_at_last"), -1, 1)),
        ("driven", wp.bool, state_field(found, "driven")),
        ("constrained", wp.bool, state_field(found, "constrained")),
        ("own_spring", wp.bool, state_field(found, "own_spring")),
        ("reel", wp.int32, reels),
        ("reel_joint", wp.int32, state_field(found, "reel_joint")),
        ("reel_radius", wp.float64, state_field(found, "reel_radius")),
        ("output_joint", wp.int32, state_field(found, "output_joint")),
        ("output_radius", wp.float64, state_field(found, "output_radius")),
    ):
        setattr(tendons, name, _array(values, kind))


def _fill_parameters(tendons: Any, found: dict[str, Simulated], nworld: int) -> None:
    """Give every world the parameters of the simulation."""
    for name in PARAMETERS:
        values = np.array([float(sheath.state["law"][name]) for sheath in found.values()])
        if name == "axial_stiffness":
            values[values == 0.0] = _STIFF
        setattr(tendons, name, _array(np.tile(values, (nworld, 1)), wp.float32))


def _fill_state(tendons: Any, found: dict[str, Simulated], nworld: int) -> None:
    """Give every world the committed state of the simulation."""

    def put(name: str, kind: Any, rows: NDArray[Any]) -> None:
        columns = np.repeat(rows[:, None], nworld, axis=1)
        setattr(tendons, name, _array(columns, kind))

    for name in COMMITTED:
        put(name, wp.float64, state_field(found, name))
    put("started", wp.bool, state_field(found, "started"))
    for name, field in (
        ("stored", "stored"),
        ("before", "previous_tension"),
        ("give", "support_compliance"),
    ):
        rows = [np.ravel(sheath.segments[field]) for sheath in found.values()]
        put(name, wp.float64, np.concatenate(rows))
    slips = [np.ravel(sheath.guides["previous_slip"]) for sheath in found.values()]
    put("previous_slip", wp.int32, np.concatenate(slips))
    arcs = np.concatenate([sheath.arcs for sheath in found.values()])
    if len(arcs):
        put("touched", wp.bool, arcs["touches"])
        for name, end in (("near_tangent", "1"), ("far_tangent", "2")):
            points = np.stack([arcs[axis + end] for axis in "xyz"], axis=-1)
            put(name, wp.vec3d, points)
