"""Numbers of a model by the names that recordings give them, ``<element>.<parameter>``.

| element | parameters |
|---|---|
| sheath | those of `tendon_mj.Parameters`: friction [-], axial_stiffness [N], … |
| joint | stiffness, damping, frictionloss, armature, springref [SI of a hinge or slide] |
| actuator | gear; kp, kv of a position servo; command_scale [-], command_offset [of its control] |
| sensor | scale [-], offset [of its reading] |

The scale and offset of actuators and sensors are the rig's: control = scale × column + offset, and
column = scale × reading + offset.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach import Parameters
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath.law import check_static

_OBJ, _JNT = mujoco.mjtObj, mujoco.mjtJoint
_Setter = Callable[[float], None]
_Place = tuple[NDArray[np.float64], int | tuple[int, int], float]  # array, index, factor


class Adjustable:
    """A model and its data with their parameters by name.

    Args:
        model: changed in place, so one's own copy.

    Attributes:
        model, data: ready to run, with what ``set`` was given.
        commands, readings: (nactuator, 2), (nsensor, 2) scale and offset, for who runs the model.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
        self.commands = np.tile([1.0, 0.0], (model.nactuator, 1))
        self.readings = np.tile([1.0, 0.0], (model.nsensor, 1))
        self._sheaths = Parameters(model, self.data)
        self._setters = self._joints() | self._actuators() | self._sensors()

    def names(self) -> list[str]:
        """Every parameter there is."""
        return sorted([*self._sheaths, *self._setters])

    def set(self, values: Mapping[str, float]) -> None:
        """Give parameters values; those that are not named keep theirs.

        Raises:
            UnknownNameError: no such parameter, with the nearest; nothing is changed then.
            InvalidValueError: a value outside its range.
        """
        known = self.names()
        for name in values:
            if name not in known:
                raise UnknownNameError("parameter", name, known)
        for name, value in values.items():
            if name in self._setters:
                self._setters[name](float(value))
            else:
                self._sheaths[name] = value
        for name in values.keys() - self._setters.keys():
            self._check_sheath(name.rsplit(".", 1)[0])
        if any(name.endswith(".armature") for name in values):
            mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def _check_sheath(self, sheath: str) -> None:
        static = self._sheaths[f"{sheath}.static_friction"]
        if static > 0.0:  # 0: not given, it is the dynamic one then
            check_static(self._sheaths[f"{sheath}.friction"], static, sheath)

    def _joints(self) -> dict[str, _Setter]:
        m, found = self.model, {}
        for joint in range(m.njnt):
            name = mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint)
            if name and m.jnt_type[joint] in (_JNT.mjJNT_HINGE.value, _JNT.mjJNT_SLIDE.value):
                dof, angle = m.jnt_dofadr[joint], m.jnt_qposadr[joint]
                for parameter, array, index, low in (
                    ("stiffness", m.jnt_stiffness, joint, 0.0),
                    ("damping", m.dof_damping, dof, 0.0),
                    ("frictionloss", m.dof_frictionloss, dof, 0.0),
                    ("armature", m.dof_armature, dof, 0.0),
                    ("springref", m.qpos_spring, angle, -math.inf),
                ):
                    key = f"{name}.{parameter}"
                    found[key] = _into(key, [(array, index, 1.0)], low)
        return found

    def _actuators(self) -> dict[str, _Setter]:
        m, found = self.model, {}
        gain, bias = m.actuator_gainprm, m.actuator_biasprm
        for k in range(m.nactuator):
            name = mujoco.mj_id2name(m, _OBJ.mjOBJ_ACTUATOR, k)
            if not name:
                continue
            slots: dict[str, tuple[list[_Place], float]] = {
                "gear": ([(m.actuator_gear, (k, 0), 1.0)], -math.inf),
                "command_scale": ([(self.commands, (k, 0), 1.0)], -math.inf),
                "command_offset": ([(self.commands, (k, 1), 1.0)], -math.inf),
            }
            if gain[k, 0] != 0.0 and gain[k, 0] == -bias[k, 1]:  # a position servo
                slots["kp"] = ([(gain, (k, 0), 1.0), (bias, (k, 1), -1.0)], 0.0)
                slots["kv"] = ([(bias, (k, 2), -1.0)], 0.0)
            for parameter, (places, low) in slots.items():
                key = f"{name}.{parameter}"
                found[key] = _into(key, places, low)
        return found

    def _sensors(self) -> dict[str, _Setter]:
        found = {}
        for k in range(self.model.nsensor):
            name = mujoco.mj_id2name(self.model, _OBJ.mjOBJ_SENSOR, k)
            for column, parameter in enumerate(("scale", "offset")):
                key = f"{name}.{parameter}"
                if name:
                    found[key] = _into(key, [(self.readings, (k, column), 1.0)], -math.inf)
        return found


def _into(name: str, places: list[_Place], low: float) -> _Setter:
    """A function that writes a checked value, times a factor, to every place."""

    def write(value: float) -> None:
        if not (math.isfinite(value) and value >= low):
            bound = f" and ≥ {low:g}" if math.isfinite(low) else ""
            raise InvalidValueError(f"{name} = {value:g} must be finite{bound}")
        for array, index, factor in places:
            array[index] = factor * value

    return write
