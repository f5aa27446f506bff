"""Load of a servo's motor: every other torque on its joint that MuJoCo knows before the servo."""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import byte, double, doubles, integer, pointer, size


@compiled
def _of_actuators(layout: Layout, m: int, d: int, dof: int, own: int) -> float:
    """Torque of the other actuators on a degree of freedom, each within its range of forces.

    MuJoCo has not summed them up yet. Those that a plugin drives come in the order of the plugins'
    instances, so that of a later one is still 0.
    """
    forces, moments = pointer(d + layout.d_actuator_force), pointer(d + layout.d_actuator_moment)
    columns = pointer(d + layout.d_moment_colind)
    total = 0.0
    for actuator in range(size(m + layout.m_nactuator)):
        if actuator == own:
            continue
        first = integer(pointer(m + layout.m_actuator_outadr), actuator)
        for row in range(first, first + integer(pointer(m + layout.m_actuator_outnum), actuator)):
            force = double(forces, row)
            if byte(pointer(m + layout.m_actuator_forcelimited), actuator):
                limits = doubles(pointer(m + layout.m_actuator_forcerange) + 16 * actuator, 2)
                force = min(max(force, limits[0]), limits[1])
            start = integer(pointer(d + layout.d_moment_rowadr), row)
            for k in range(start, start + integer(pointer(d + layout.d_moment_rownnz), row)):
                if integer(columns, k) == dof:
                    total += double(moments, k) * force
    return total


@compiled
def known_torque(layout: Layout, m: int, d: int, dof: int, own: int) -> float:
    """Torque on a degree of freedom but for actuator ``own`` and constraints [N m].

    Springs, dampers, gravity, the tendon on its spool, what the user applies, other actuators.
    Forces of contacts, limits and dry friction follow later in the step, from all of this.
    """
    return (
        double(pointer(d + layout.d_qfrc_passive), dof)
        + double(pointer(d + layout.d_qfrc_applied), dof)
        - double(pointer(d + layout.d_qfrc_bias), dof)
        + _of_actuators(layout, m, d, dof, own)
    )
