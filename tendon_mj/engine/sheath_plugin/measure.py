"""What a sensor of the plugin can show."""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import doubles
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.sheath.tables import FLOW
from tendon_mj.sheath.tables import SLIP as SLIP_ROW
from tendon_mj.sheath.tables import TENSION as TENSION_ROW

# kind -> (what it is, unit, whether one number per "segment" or "guide" or one in all)
KINDS: dict[str, tuple[str, str, str]] = {
    "input_tension": ("tension at the input end", "N", "one"),
    "output_tension": ("tension at the output end", "N", "one"),
    "tension": ("tension of each segment, input side first", "N", "segment"),
    "bend_angle": ("bend at each guide", "rad", "guide"),
    "slip": ("+1 sliding towards the input, -1 towards the output, 0 at rest", "-", "guide"),
    "friction_work": ("energy that each guide has turned to heat since the reset", "J", "guide"),
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


def width(kind: str, guides: int) -> int:
    """How many numbers a sensor of this kind has on a sheath with so many guides."""
    return {"one": 1, "segment": guides + 1, "guide": guides}[KINDS[kind][2]]


@compiled
def measure_ends(address: int, out: int) -> None:
    """Write T_in and T_out of the sheath at ``address``."""
    state, segments, _, _ = st.unpack(address)
    shown = doubles(out, ENDS)
    shown[0] = state[st.AXIAL_STIFFNESS] * segments[TENSION_ROW, 0]
    shown[1] = state[st.AXIAL_STIFFNESS] * segments[TENSION_ROW, segments.shape[1] - 1]


@compiled
def measure(address: int, kind: int, out: int) -> None:
    """Write at ``out`` what a sensor shows of the sheath at ``address``."""
    state, segments, guides, _ = st.unpack(address)
    last = guides.shape[1]
    shown = doubles(out, last + 1)
    ea = state[st.AXIAL_STIFFNESS]
    if kind == INPUT_TENSION:
        shown[0] = ea * segments[TENSION_ROW, 0]
    elif kind == OUTPUT_TENSION:
        shown[0] = ea * segments[TENSION_ROW, last]
    elif kind == TENSION:
        for j in range(last + 1):
            shown[j] = ea * segments[TENSION_ROW, j]
    elif kind == REEL_DISPLACEMENT:
        shown[0] = state[st.TRIAL_WOUND_IN]
    elif kind == UNSOLVED:
        shown[0] = state[st.UNSOLVED]
    else:
        for i in range(last):
            if kind == BEND_ANGLE:
                shown[i] = guides[st.ANGLE, i]
            elif kind == SLIP:
                shown[i] = guides[SLIP_ROW, i] if guides[FLOW, i] != 0.0 else 0.0
            else:
                shown[i] = guides[st.WORK, i] + guides[st.TRIAL_WORK, i]
