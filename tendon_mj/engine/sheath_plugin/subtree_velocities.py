"""Skipping the velocities of subtrees where nothing reads them.

MuJoCo computes them before it asks any plugin for sensors of the velocity stage, unless its flag
says that they are there; a sheath, whose tension is known only in that stage, has no use for them.
They would be a tenth of what two sheaths cost a finger in a step. Who reads them are MuJoCo's own
sensors of subtrees, the user's, and other plugins: in a model with any of those all stays as it is.
"""

from __future__ import annotations

import mujoco

from tendon_mj.abi.layout import Layout
from tendon_mj.abi.memory import byte, integer, pointer, set_byte, size
from tendon_mj.compilation import compiled

_SENSOR = mujoco.mjtSensor
READERS = tuple(
    kind.value
    for kind in (_SENSOR.mjSENS_SUBTREELINVEL, _SENSOR.mjSENS_SUBTREEANGMOM, _SENSOR.mjSENS_USER)
)


@compiled
def are_read(layout: Layout, readers: tuple[int, ...], m: int, instance: int) -> bool:
    """Whether a model has anything beside the plugin of ``instance`` that may read them.

    Args:
        layout, m: where things are, `mjModel`.
        readers: the sensors that do, ``READERS``.
        instance: of a plugin that does not.
    """
    kinds = pointer(m + layout.m_sensor_type)
    for sensor in range(size(m + layout.m_nsensor)):
        if integer(kinds, sensor) in readers:
            return True
    slots = pointer(m + layout.m_plugin)
    for other in range(size(m + layout.m_nplugin)):
        if integer(slots, other) != integer(slots, instance):
            return True
    return False


@compiled
def skip_subtree_velocities(
    layout: Layout, readers: tuple[int, ...], m: int, d: int, instance: int
) -> None:
    """Tell MuJoCo that they are there, unless somebody reads them.

    It takes that back where it next begins. The model is asked every time: a state may come from
    another model, without the sensor that this one has.
    """
    flag = d + layout.d_flg_subtreevel
    if byte(flag, 0) == 0 and not are_read(layout, readers, m, instance):
        set_byte(flag, 1)
