"""Sensors of the plugin: the quantities that they show of a sheath."""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.memory import doubles
from tendon_mj.plugin.sheath_plugin.state import state_at, unpack

# kind -> (quantity, unit, whether one number per "segment" or "guide" or one in all)
KINDS: dict[str, tuple[str, str, str]] = {
    "input_tension": ("tension at the input end", "N", "one"),
    "output_tension": ("tension at the output end", "N", "one"),
    "tension": ("tension of each segment, input side first", "N", "segment"),
    "bend_angle": ("bend at each guide", "rad", "guide"),
    "slip": ("+1 sliding towards the input, -1 towards the output, 0 at rest", "-", "guide"),
    "friction_work": ("friction work at each guide since the reset", "J", "guide"),
    "reel_displacement": ("tendon wound in at the input", "m", "one"),
    "unsolved": ("evaluations whose flow was not solved since the reset", "-", "one"),
}
(
    INPUT_TENSION,
    OUTPUT_TENSION,
    TENSION,
    BEND_ANGLE,
    SLIP,
    FRICTION_WORK,
    REEL_DISPLACEMENT,
    UNSOLVED,
) = range(len(KINDS))


ENDS = 2  # numbers of a sensor on the sheath's own instance: T_in and T_out


def is_one_number(kind: str) -> bool:
    """Whether a sensor of this kind has one number, whatever its sheath."""
    return KINDS[kind][2] == "one"


def width(kind: str, guides: int) -> int:
    """How many numbers a sensor of this kind has on a sheath with so many guides."""
    return {"one": 1, "segment": guides + 1, "guide": guides}[KINDS[kind][2]]


@compiled
def numbers_of(kind: int, guides: int) -> int:
    """How many numbers ``measure`` writes."""
    if kind == TENSION:
        return guides + 1
    return guides if kind in (BEND_ANGLE, SLIP, FRICTION_WORK) else 1


@compiled
def measure_ends(address: int, out: int) -> None:
    """Write T_in and T_out of the sheath at ``address``."""
    state = state_at(address)
    segments, _, _ = unpack(address)
    shown = doubles(out, ENDS)
    shown[0] = state.law.axial_stiffness * segments[0].tension
    shown[1] = state.law.axial_stiffness * segments[len(segments) - 1].tension


@compiled
def measure(address: int, kind: int, out: int) -> None:
    """Write at ``out`` the quantity ``kind`` of the sheath at ``address``."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    last = len(guides)
    shown = doubles(out, last + 1)
    ea = state.law.axial_stiffness
    if kind == INPUT_TENSION:
        shown[0] = ea * segments[0].tension
    elif kind == OUTPUT_TENSION:
        shown[0] = ea * segments[last].tension
    elif kind == TENSION:
        for j in range(last + 1):
            shown[j] = ea * segments[j].tension
    elif kind == REEL_DISPLACEMENT:
        shown[0] = state.trial_wound_in
    elif kind == UNSOLVED:
        shown[0] = state.unsolved
    else:
        for i in range(last):
            if kind == BEND_ANGLE:
                shown[i] = guides[i].angle
            elif kind == SLIP:
                shown[i] = guides[i].slip if guides[i].flow != 0.0 else 0.0
            else:
                shown[i] = guides[i].friction_work + guides[i].trial_friction_work
