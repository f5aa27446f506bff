"""The tensions at the ends of the colour bar, by which a model says that its tendons are drawn.

They are the two numbers [N] of a custom numeric of the model.
"""

from __future__ import annotations

import mujoco

from tendon_mj.compilation import compiled
from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.library import C, mj_name2id
from tendon_mj.plugin.abi.memory import double, integer, pointer, text
from tendon_mj.plugin.abi.model_in_compilation import Draft

TENSION_SCALE = "tendon_mj.tension_scale"
_NUMERIC = mujoco.mjtObj.mjOBJ_NUMERIC.value
_name = text(TENSION_SCALE)


@compiled
def tension_scale(layout: Layout, m: int) -> tuple[float, float]:
    """Tensions at the ends of the colour bar [N], both 0 where the model says none."""
    numeric = mj_name2id(m, _NUMERIC, _name())
    if numeric < 0 or integer(pointer(m + layout.m_numeric_size), numeric) < 2:
        return 0.0, 0.0
    start = integer(pointer(m + layout.m_numeric_adr), numeric)
    scale = pointer(m + layout.m_numeric_data) + 8 * start
    return double(scale, 0), double(scale, 1)


def check_tension_scale(model: Draft) -> None:
    """Check the custom numeric, if the model has it.

    Raises:
        InvalidValueError: it is not two finite tensions, the lower one first.
    """
    numeric = C.mj_name2id(model.address, _NUMERIC, TENSION_SCALE.encode())
    if numeric < 0:
        return
    start, count = model.ints("numeric_adr")[numeric], model.ints("numeric_size")[numeric]
    check_limits(*model.doubles("numeric_data")[start : start + count])


def check_limits(*limits: float) -> None:
    """Check the tensions at the ends of a colour bar.

    Raises:
        InvalidValueError: they are not two finite tensions, the lower one first.
    """
    if len(limits) != 2 or not -float("inf") < limits[0] < limits[1] < float("inf"):
        shown = " ".join(f"{limit:g}" for limit in limits)
        raise InvalidValueError(
            f"custom numeric {TENSION_SCALE!r} = {shown!r} must be two tensions [N], the lower one "
            "first"
        )
