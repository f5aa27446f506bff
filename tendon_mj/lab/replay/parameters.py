"""Parameters of a model by the names used in recordings, ``<element>.<parameter>``.

| element | parameters |
|---|---|
| sheath, servo | those of `tendon_mj.Parameters`: friction [-], axial_stiffness [N], … |
| sheath | drawn_bend [rad] of its path at qpos0, see `live_parameters` |
| joint | stiffness, damping, frictionloss, armature, springref [SI of a hinge or slide] |
| body that moves | mass [kg], with which its inertia grows in proportion |
| actuator | gear; kp, kv of a position servo |
| | command_scale [-], command_offset [of its control], command_delay [s] |
| joint | the same three, of a column that prescribes its position |
| | slip [of its control], slip_time and slip_duration [s], of one that takes a place |
| sensor | scale [-], offset [of its reading], delay [s], lag [s], drift [of its reading per s] |
| | efficiency, rest_in and rest_out [-] of a gear, of T_in and of an actuator's force |
| gravity | x, y, z [m/s²] |

The commands of actuators and the parameters of sensors are the rig's:
control(t) = scale × column(t − delay) + offset, and a column is what `Readout` makes of a reading.
Over its ``slip_duration`` from its ``slip_time`` on, a control becomes more by its ``slip``, as
where the cable slips on its drum.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, Literal, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach import as_number
from tendon_mj.errors import InvalidValueError, UnknownKeyError, UnknownNameError
from tendon_mj.lab.recordings import excess
from tendon_mj.lab.replay.live_parameters import DRAWN_BEND, LiveParameters, custom_numbers
from tendon_mj.lab.replay.muscle import ranges_of_gear
from tendon_mj.lab.replay.readout import (
    USER_NUMBERS,
    Readout,
    stored_commands,
    stored_joint_commands,
    stored_readouts,
)
from tendon_mj.lab.replay.units import JOINT, UNKNOWN, control_unit, live_unit, rate
from tendon_mj.plugin import C, sensor_kind, sheath_arrays, sheaths
from tendon_mj.sheath import LAW, check_scales, check_static

_OBJ, _JNT, _TRN = mujoco.mjtObj, mujoco.mjtJoint, mujoco.mjtTrn
_Place = tuple[NDArray[np.float64], int | tuple[int, int], float]  # array, index, factor
GEAR: Final = ".gear"  # custom text of a model: the numbers of a sensor's gear
GEARED: Final = ("efficiency", "rest_in", "rest_out")
SLIP: Final = ("slip", "slip_time", "slip_duration")
_PLACES = "m", "rad"  # units of a control that is a place
_LEAST_EFFICIENCY = 1e-3

_COMMANDS = {"command_scale": -math.inf, "command_offset": -math.inf, "command_delay": 0.0}  # least

Kind = Literal["live", "joint", "body", "actuator", "motor", "sensor", "gravity"]


class Parameter(NamedTuple):
    """A number of a model: its value, its unit, and what kind of element has it.

    ``live``: of a sheath or servo, in `mjData.plugin_state`. ``motor``: an actuator whose force
    depends on nothing but its control. ``low``: the least that it may be. ``joints``: those that an
    actuator is on, or that move a body, its own first. ``reference``: of a position, what it is in
    the model's reference pose (qpos0).
    """

    value: float
    unit: str
    kind: Kind
    low: float = -math.inf
    joints: tuple[str, ...] = ()
    reference: float = 0.0


class _Entry(NamedTuple):
    kind: Kind
    unit: str
    places: list[_Place]
    low: float = -math.inf
    joints: tuple[str, ...] = ()
    reference: float = 0.0


class Adjustable:
    """A model and its data with their parameters by name.

    Args:
        model: changed in place, so one's own copy.

    Attributes:
        model, data: ready to run, with what ``set`` was given.
        commands: (nactuator, 6) scale, offset, delay, slip, its time and its duration, for who
            runs the model.
        joint_commands: (njnt, 3) scale, offset and delay of columns that prescribe joints.
        readings: (nsensor, 8) `Readout` of every sensor, for who runs the model.
        geared: sensor of a load → actuators that may bear it, and the sense, 1 or −1, in which
            the control of each moves against the load.
        live: those of sheaths and servos alone.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
        self.commands = np.hstack([stored_commands(model), np.zeros((model.nactuator, len(SLIP)))])
        self.joint_commands = stored_joint_commands(model)
        self.live = LiveParameters(model, self.data)
        self.geared = self._geared()
        gearless = np.tile(Readout()[USER_NUMBERS:], (model.nsensor, 1))
        self.readings = np.hstack([stored_readouts(model), gearless])
        for sensor in self.geared:
            text = mujoco.mj_name2id(model, _OBJ.mjOBJ_TEXT, model.sensor(sensor).name + GEAR)
            if text >= 0:
                self.readings[sensor, -len(GEARED) :] = custom_numbers(model, text, len(GEARED))
        self._entries = (
            self._joints() | self._bodies() | self._actuators() | self._sensors() | self._gravity()
        )
        for name, entry in self._entries.items():
            if entry.kind == "sensor" or ".command_" in name:  # user data, which nobody checked
                _check(name, entry, _value(entry))

    def names(self) -> list[str]:
        """Every parameter there is."""
        return sorted([*self.live, *self._entries])

    def parameters(self) -> dict[str, Parameter]:
        """Every parameter as it is now."""
        found = {
            name: Parameter(value, live_unit(name.rsplit(".", 1)[1]), "live", _least(name))
            for name, value in self.live.items()
        }
        found |= {
            name: Parameter(_value(entry), entry.unit, entry.kind, *entry[3:])
            for name, entry in self._entries.items()
        }
        return dict(sorted(found.items()))

    def set(self, values: Mapping[str, float]) -> None:
        """Give parameters values; those that are not named keep theirs.

        Raises:
            UnknownNameError: no such parameter, with the nearest; nothing is changed then.
            UnusedKeyError: one that a sheath has no use for, and why; likewise.
            InvalidValueError: a value outside its range.
        """
        for name in values:
            if name in self._entries:
                continue
            try:
                self.live[name]
            except UnknownKeyError:
                raise UnknownNameError("parameter", name, self.names()) from None
        for name, given in values.items():
            value = as_number(name, given)
            if name in self._entries:
                entry = self._entries[name]
                _check(name, entry, value)
                for array, index, factor in entry.places:
                    array[index] = factor * value
            else:
                self.live[name] = value
        for name in values.keys() - self._entries.keys():
            self._check_sheath(name.rsplit(".", 1)[0])
        muscles = [n for n in values.keys() & self._entries.keys() if self._is_gear_of_muscle(n)]
        if muscles:  # a gear of the other sign has turned the ends around
            self.model.actuator_lengthrange.sort(axis=1)
        if muscles or any(name.endswith((".armature", ".mass")) for name in values):
            mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def _is_gear_of_muscle(self, name: str) -> bool:
        return name.endswith(".gear") and len(self._entries[name].places) > 1

    def _check_sheath(self, sheath: str) -> None:
        law = {name: self.live.get(f"{sheath}.{name}", 0.0) for name in LAW}  # a servo has none
        if law["static_friction"] > 0.0:  # 0: not given, it is the dynamic one then
            check_static(law["friction"], law["static_friction"], sheath)
        check_scales(law, sheath)

    def _joints(self) -> dict[str, _Entry]:
        m, found = self.model, {}
        for joint in range(m.njnt):
            name = mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint)
            if name and m.jnt_type[joint] in (_JNT.mjJNT_HINGE.value, _JNT.mjJNT_SLIDE.value):
                dof, angle = m.jnt_dofadr[joint], m.jnt_qposadr[joint]
                slides = bool(m.jnt_type[joint] == _JNT.mjJNT_SLIDE.value)
                for parameter, array, index, low in (
                    ("stiffness", m.jnt_stiffness, joint, 0.0),
                    ("damping", m.dof_damping, dof, 0.0),
                    ("frictionloss", m.dof_frictionloss, dof, 0.0),
                    ("armature", m.dof_armature, dof, 0.0),
                    ("springref", m.qpos_spring, angle, -math.inf),
                ):
                    unit = JOINT[parameter][slides]
                    places: list[_Place] = [(array, index, 1.0)]
                    found[f"{name}.{parameter}"] = _Entry("joint", unit, places, low)
                entry = found[f"{name}.springref"]
                found[f"{name}.springref"] = entry._replace(reference=float(m.qpos0[angle]))
                units = ("-", JOINT["springref"][slides], "s")
                for k, (parameter, low) in enumerate(_COMMANDS.items()):
                    places = [(self.joint_commands, (joint, k), 1.0)]
                    found[f"{name}.{parameter}"] = _Entry("joint", units[k], places, low)
        return found

    def _bodies(self) -> dict[str, _Entry]:
        m, found = self.model, {}
        for body in range(1, m.nbody):
            name, mass = mujoco.mj_id2name(m, _OBJ.mjOBJ_BODY, body), float(m.body_mass[body])
            if not name or mass == 0.0 or m.body_weldid[body] == 0:
                continue
            places: list[_Place] = [(m.body_mass, body, 1.0)]
            for axis in range(3):
                ratio = float(m.body_inertia[body, axis]) / mass
                places.append((m.body_inertia, (body, axis), ratio))
            entry = _Entry("body", "kg", places, mujoco.mjMINVAL, self._joints_above(body))
            found[f"{name}.mass"] = entry
        return found

    def _joints_above(self, body: int) -> tuple[str, ...]:
        """Joints that have a name and move a body, its own first."""
        m, found = self.model, list[str]()
        while body:
            first = m.body_jntadr[body]
            joints = range(first, first + m.body_jntnum[body])
            found += [mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint) or "" for joint in joints]
            body = m.body_parentid[body]
        return tuple(filter(None, found))

    def _actuators(self) -> dict[str, _Entry]:
        m, found = self.model, {}
        gain, bias = m.actuator_gainprm, m.actuator_biasprm
        for k in range(m.nactuator):
            name = mujoco.mj_id2name(m, _OBJ.mjOBJ_ACTUATOR, k)
            if not name:
                continue
            geared: list[_Place] = [(m.actuator_gear, (k, 0), 1.0), *ranges_of_gear(m, k)]
            slots: dict[str, tuple[str, list[_Place], float]] = {
                "gear": ("-", geared, -math.inf),
            }
            for number, (parameter, low) in enumerate(_COMMANDS.items()):
                unit = ("-", UNKNOWN, "s")[number]
                slots[parameter] = (unit, [(self.commands, (k, number), 1.0)], low)
            if (unit := control_unit(m, k)) in _PLACES:
                slots["slip"] = (unit, [(self.commands, (k, 3), 1.0)], -math.inf)
                slots["slip_time"] = ("s", [(self.commands, (k, 4), 1.0)], -math.inf)
                slots["slip_duration"] = ("s", [(self.commands, (k, 5), 1.0)], 0.0)
            if gain[k, 0] != 0.0 and gain[k, 0] == -bias[k, 1]:  # a position servo
                slides = not self._turns(k)
                places: list[_Place] = [(gain, (k, 0), 1.0), (bias, (k, 1), -1.0)]
                slots["kp"] = (JOINT["stiffness"][slides], places, 0.0)
                slots["kv"] = (JOINT["damping"][slides], [(bias, (k, 2), -1.0)], 0.0)
            kind: Kind = "motor" if self._is_motor(k) else "actuator"
            joint = self._joint_of(k)
            on = mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint) if joint >= 0 else None
            for parameter, (unit, places, low) in slots.items():
                entry = _Entry(kind, unit, places, low, (on,) if on else ())
                found[f"{name}.{parameter}"] = entry
        return found

    def _joint_of(self, actuator: int) -> int:
        """The joint that it is on, or −1."""
        on_joint = _TRN.mjTRN_JOINT.value, _TRN.mjTRN_JOINTINPARENT.value
        m = self.model
        return (
            int(m.actuator_trnid[actuator, 0]) if m.actuator_trntype[actuator] in on_joint else -1
        )

    def _turns(self, actuator: int) -> bool:
        """Whether it moves a hinge."""
        joint = self._joint_of(actuator)
        return bool(joint >= 0 and self.model.jnt_type[joint] == _JNT.mjJNT_HINGE.value)

    def _is_motor(self, actuator: int) -> bool:
        """Whether its force is its control times a gain."""
        m = self.model
        return bool(
            m.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED.value
            and m.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE.value
            and m.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE.value
            and m.actuator_plugin[actuator] < 0
        )

    def _geared(self) -> dict[int, dict[int, float]]:
        """Find what ``geared`` holds, of sensors of T_in and of actuators' forces."""
        m, found = self.model, dict[int, dict[int, float]]()
        places = [k for k in range(m.nactuator) if control_unit(m, k) in _PLACES]
        states = [
            sheath_arrays(m, self.data.plugin_state, name, sheath.state).state
            for name, sheath in sheaths(m).items()
        ]
        for sensor in range(m.nsensor):
            if m.sensor_type[sensor] == mujoco.mjtSensor.mjSENS_ACTUATORFRC.value:
                found[sensor] = {k: 1.0 for k in places if k == m.sensor_objid[sensor]}
            elif states and sensor_kind(m, sensor) == "input_tension":
                tendon = _shown_tendon(m, sensor)
                for state in states:
                    if tendon == int(state["tendon"]):
                        senses = {k: self._winding(k, state) for k in places}
                        found[sensor] = {k: sense for k, sense in senses.items() if sense}
        return {sensor: by for sensor, by in found.items() if by}

    def _winding(self, actuator: int, state: NDArray[np.void]) -> float:
        """Sense in which a control winds in the tendon of a sheath; 0 where it does not."""
        m, joint, gear = self.model, self._joint_of(actuator), self.model.actuator_gear[actuator, 0]
        if actuator == int(state["reel_actuator"]):
            return 1.0
        if joint >= 0 and joint == int(state["reel_joint"]):
            return float(np.sign(gear * state["reel_radius"]))
        pulls = m.actuator_trntype[actuator] == _TRN.mjTRN_TENDON.value
        own = pulls and m.actuator_trnid[actuator, 0] == int(state["tendon"])
        return -float(np.sign(gear)) if own and m.actuator_plugin[actuator] < 0 else 0.0

    def _sensors(self) -> dict[str, _Entry]:
        found = {}
        units = Readout("-", UNKNOWN, "s", "s", rate(UNKNOWN), "-", "-", "-")  # type: ignore[arg-type]
        least = {"delay": 0.0, "lag": 0.0, "efficiency": _LEAST_EFFICIENCY}
        for k in range(self.model.nsensor):
            name = mujoco.mj_id2name(self.model, _OBJ.mjOBJ_SENSOR, k)
            for column, parameter in enumerate(Readout._fields):
                low = least.get(parameter, -math.inf)
                places: list[_Place] = [(self.readings, (k, column), 1.0)]
                if name and (parameter not in GEARED or k in self.geared):
                    entry = _Entry("sensor", str(units[column]), places, low)
                    found[f"{name}.{parameter}"] = entry
        return found

    def _gravity(self) -> dict[str, _Entry]:
        gravity = self.model.opt.gravity
        return {
            f"gravity.{axis}": _Entry("gravity", "m/s²", [(gravity, k, 1.0)])
            for k, axis in enumerate("xyz")
        }


def _shown_tendon(model: mujoco.MjModel, sensor: int) -> int:
    """The tendon whose sheath a sensor shows, by its object or by what its instance names."""
    if model.sensor_objtype[sensor] == _OBJ.mjOBJ_TENDON.value:
        return int(model.sensor_objid[sensor])
    instance = int(model.sensor_plugin[sensor])
    written = C.mj_getPluginConfig(model._address, instance, b"tendon") or b""
    return int(mujoco.mj_name2id(model, _OBJ.mjOBJ_TENDON, written.decode()))


def _least(name: str) -> float:
    """Least value that a live parameter may have."""
    parameter = name.rsplit(".", 1)[1]
    if parameter == DRAWN_BEND:
        return 0.0
    law = LAW.get(parameter)
    return 0.0 if law is not None and not law.range.admits(-1.0) else -math.inf


def _value(entry: _Entry) -> float:
    array, index, factor = entry.places[0]
    return float(array[index]) * factor + 0.0  # + 0: no negative zero


def _check(name: str, entry: _Entry, value: float) -> None:
    if not (math.isfinite(value) and value >= entry.low):
        bound = f" and ≥ {entry.low:g}" if math.isfinite(entry.low) else ""
        raise InvalidValueError(f"{name} = {value:g} must be finite{bound}")
    if fault := excess(value):
        raise InvalidValueError(f"{name} = {fault}")
