"""Parameters of a model by the names used in recordings, ``<element>.<parameter>``.

| element | parameters |
|---|---|
| sheath, servo | those of `tendon_mj.Parameters`: friction [-], axial_stiffness [N], … |
| sheath | drawn_bend [rad] of its path at qpos0, see `DrawnBends` |
| joint | stiffness, damping, frictionloss, armature, springref [SI of a hinge or slide] |
| joint or tendon with limits | range_low, range_high, range_width, which scales both [its unit] |
| body that moves | mass [kg], with which its inertia grows in proportion |
| actuator | gear; kp, kv of a position servo |
| | command_scale [-], command_offset [of its control], command_delay [s] |
| joint | the same three, of a column that prescribes its position |
| | slip [of its control], slip_time and slip_duration [s], of one that takes a place |
| sensor | scale [-], offset [of its reading], delay [s], lag [s], drift [of its reading per s] |
| | efficiency, rest_in and rest_out [-] of a gear, of T_in and of an actuator's force |
| gravity | x, y, z [m/s²] |

The commands of actuators and the parameters of sensors are the rig's:
control(t) = scale × column(t − delay) + offset, and `Readout` makes a column of a reading.
Over its ``slip_duration`` from its ``slip_time`` on, a control becomes more by its ``slip``, as
where the cable slips on its drum.

A joint without `frictionloss` has no softness of it that anybody chose: where MuJoCo's own stands,
with which a joint at rest creeps, it gets a stiff one. Nor has a pulley without play a flank on
which its joint rests: that is the one on which gravity and springs load it where angles are zeroed,
in the reference pose.
"""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Mapping
from functools import cached_property
from typing import Any, Final, Literal, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach import Parameters, checked_number
from tendon_mj.errors import InvalidValueError, TendonWarning, UnknownKeyError, UnknownNameError
from tendon_mj.lab.replay.readout import (
    PLAIN_COMMAND,
    USER_NUMBERS,
    Readout,
    custom_numbers,
    stored_commands,
    stored_joint_commands,
    stored_readouts,
)
from tendon_mj.lab.replay.units import control_unit, reading_unit
from tendon_mj.lab.units import JOINT, LARGEST, ROUNDING, rate
from tendon_mj.plugin import GAINS, PARAMETERS, C, sensor_kind, sheath_arrays, sheaths
from tendon_mj.sheath import LAW, check_scales, check_static

_OBJ, _TRN = mujoco.mjtObj, mujoco.mjtTrn
_HINGE, _SLIDE = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
_ON_JOINT = _TRN.mjTRN_JOINT.value, _TRN.mjTRN_JOINTINPARENT.value
_Place = tuple[NDArray[np.float64], int | tuple[int, int], float]  # array, index, factor
RANGE_WIDTH: Final = "range_width"
RANGE_ENDS: Final = ("range_low", "range_high")
_PLAYS = {"reel_play": "reel_joint", "output_play": "output_joint"}
OUTPUT_REST: Final = "output_rest"
EXTRA_BEND: Final = "extra_bend"
DRAWN_BEND: Final = "drawn_bend"
CORRECTION: Final = ".drawn_bend.correction"  # custom text of a model: Σ φ_i to drawn_bend [rad]
GEAR: Final = ".gear"  # custom text of a model: the numbers of a sensor's gear
GEARED: Final = ("efficiency", "rest_in", "rest_out")
SLIP: Final = ("slip", "slip_time", "slip_duration")
_PLACES = "m", "rad"  # units of a control that is a place

# MuJoCo's own softness of dry friction, with which a joint creeps at rest; and a stiff one
_SOFT_SOLREF, _SOFT_SOLIMP = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)
_STIFF_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)

_PLAIN_DRIVE = {**PLAIN_COMMAND, **dict.fromkeys(SLIP, 0.0)}
_COMMANDS = {"command_scale": -math.inf, "command_offset": -math.inf, "command_delay": 0.0}  # least

Kind = Literal["live", "joint", "tendon", "body", "actuator", "motor", "sensor", "gravity"]


class Parameter(NamedTuple):
    """A number of a model: its value, its unit, and the kind of its element.

    ``live``: of a sheath or servo, in `mjData.plugin_state`. ``motor``: an actuator whose force
    depends on nothing but its control. ``low``: the least that it may be. ``joints``: those that an
    actuator is on, or that move a body, its own first. ``reference``: of a position, its value in
    the model's reference pose (qpos0).
    """

    value: float
    unit: str
    kind: Kind
    low: float = -math.inf
    joints: tuple[str, ...] = ()
    reference: float = 0.0

    def is_plain(self, name: str) -> bool:
        """Return whether it, of this name, is of a column of which the model states nothing."""
        parameter = name.rsplit(".", 1)[1]
        plain = Readout()._asdict() if self.kind == "sensor" else _PLAIN_DRIVE
        return plain.get(parameter) == self.value


class DrawnBends:
    """Bends of the drawn paths of a model's sheaths.

        φ_x of the law = extra_bend + (drawn_bend − Σ φ_i),   φ_i of the guides at qpos0 [rad]

    ``drawn_bend`` starts at Σ φ_i, and another value acts as that much more ``extra_bend``: shared
    evenly by the guides at sites and at the input end, none of which bends by less than 0. A sheath
    without such guides, as where all are on geoms, has none: nothing would take it up. Paths are
    computed when the first is asked for or set.
    """

    def __init__(self, model: mujoco.MjModel, live: Parameters) -> None:
        self._model, self._live = model, live
        # sheath → difference of its drawn bend from the path's [rad]; and ``extra_bend`` without it
        stored = custom_numbers(model, CORRECTION, 1, lambda name: name in sheaths(model))
        self.corrections = {sheath: correction for sheath, (correction,) in stored.items()}
        self._added = {
            sheath: live[f"{sheath}.{EXTRA_BEND}"] - correction
            for sheath, correction in self.corrections.items()
        }

    @cached_property
    def _of_paths(self) -> dict[str, float]:
        """Σ φ_i of the sheaths that have a guide which takes up a bend that is not drawn."""
        model, known = self._model, sheaths(self._model)
        if not known:
            return {}
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        paths = {name: self._path(data, name) for name in known}
        if any(path.state["arcs"] for path in paths.values()):
            mujoco.mj_step(model, data)  # a wrap bends only from the step after it came on
            data.qpos[:] = model.qpos0
            mujoco.mj_forward(model, data)
            paths = {name: self._path(data, name) for name in known}
        bends = {}
        for name, path in paths.items():
            alone = path.state["arcs"] * path.state["arc_guides"] + path.state["pulleys"]
            if len(path.guides) > alone:
                bends[name] = float(path.guides["angle"].sum())
        return bends

    def _path(self, data: mujoco.MjData, sheath: str) -> Any:
        start = sheaths(self._model)[sheath].state
        return sheath_arrays(self._model, data.plugin_state, sheath, start)

    def values(self) -> dict[str, float]:
        """Every drawn bend, and the extra bend next to each that was set."""
        extra = {f"{sheath}.{EXTRA_BEND}": added for sheath, added in self._added.items()}
        return extra | {
            f"{sheath}.{DRAWN_BEND}": bend + self.corrections.get(sheath, 0.0)
            for sheath, bend in self._of_paths.items()
        }

    def has(self, name: str) -> bool:
        """Return whether a name is of a drawn bend, or of an extra bend beside one that was set."""
        sheath, _, parameter = name.rpartition(".")
        if parameter == DRAWN_BEND:
            return sheath in self._of_paths
        return parameter == EXTRA_BEND and sheath in self.corrections

    def set(self, name: str, value: float) -> None:
        """Set one of the parameters that it has."""
        sheath, _, parameter = name.rpartition(".")
        extra_bend = f"{sheath}.{EXTRA_BEND}"
        if parameter == DRAWN_BEND:
            _check(name, 0.0, value)
            added = self._added.get(sheath, self._live[extra_bend])
            correction = value - self._of_paths[sheath]
        else:
            added, correction = value, self.corrections[sheath]
        self._live[extra_bend] = added + correction
        self._added[sheath], self.corrections[sheath] = added, correction


class Adjustable:
    """A model, which is changed in place, and its data with their parameters by name.

    Both are ready to run with the values that ``set`` was given. Commands and readings are for the
    caller who runs them.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
        # (nactuator, 6) scale, offset, delay, slip, its time and its duration
        self.commands = np.hstack([stored_commands(model), np.zeros((model.nactuator, len(SLIP)))])
        # (njnt, 3) scale, offset and delay of columns that prescribe joints
        self.joint_commands = stored_joint_commands(model)
        self.live = Parameters(model, self.data)  # of sheaths and servos alone
        self._live_names = frozenset(self.live)  # a sheath's own name alone: each has one key here
        self.bends = DrawnBends(model, self.live)
        # sensor of a load → actuators that may bear it, and in which sense, 1 or −1, the control of
        # each moves against the load
        self.geared = _geared(model, self.data)
        gearless = np.tile(Readout()[USER_NUMBERS:], (model.nsensor, 1))
        # (nsensor, 8) `Readout` of every sensor
        self.readings = np.hstack([stored_readouts(model), gearless])
        geared = {model.sensor(k).name: k for k in self.geared}
        stored = custom_numbers(model, GEAR, len(GEARED), geared.__contains__)
        for name, numbers in stored.items():
            self.readings[geared[name], -len(GEARED) :] = numbers
        self._entries: dict[str, tuple[Parameter, tuple[_Place, ...]]] = {}
        self._winding_joints = self._rest_on_flanks()
        _stiffen_friction(model)
        self._add_joints()
        self._add_limits()
        self._add_bodies()
        self._add_actuators()
        self._add_sensors()
        for k, axis in enumerate("xyz"):
            self._add(f"gravity.{axis}", "gravity", "m/s²", (model.opt.gravity, k, 1.0))
        for name, (parameter, _) in self._entries.items():
            if parameter.kind == "sensor" or ".command_" in name:  # user data, which nobody checked
                _check(name, parameter.low, parameter.value)

    def names(self) -> list[str]:
        """Every parameter there is."""
        return sorted({*self.live, *self.bends.values(), *self._entries})

    def parameters(self) -> dict[str, Parameter]:
        """Every parameter as it is now."""
        values = {**self.live, **self.bends.values()}
        live = {name: self._live(name, value) for name, value in values.items()}
        others = {
            name: parameter._replace(value=_value(places))
            for name, (parameter, places) in self._entries.items()
        }
        return dict(sorted((live | others).items()))

    def set(self, values: Mapping[str, float]) -> None:
        """Give parameters values; those that are not named keep theirs."""
        for name in values:
            if name in self._entries or self.bends.has(name) or name in self._live_names:
                continue
            with contextlib.suppress(UnknownKeyError):
                self.live[name]  # which may be one that the sheath does not use
            raise UnknownNameError("parameter", name, self.names())
        for name, given in values.items():
            value = checked_number(name, given)
            if name in self._entries:
                parameter, places = self._entries[name]
                _check(name, parameter.low, value)
                for array, index, factor in places:
                    array[index] = factor * value
            elif self.bends.has(name):
                self.bends.set(name, value)
            else:
                with warnings.catch_warnings():  # values of a search; of the step it tells itself
                    warnings.simplefilter("ignore", TendonWarning)
                    self.live[name] = value
        for name in values.keys() - self._entries.keys():
            self._check_sheath(name.rsplit(".", 1)[0])
        gears = [name for name in values.keys() & self._entries.keys() if name.endswith(".gear")]
        muscles = any(len(self._entries[name][1]) > 1 for name in gears)
        if muscles:  # a gear of the other sign has turned the ends around
            self.model.actuator_lengthrange.sort(axis=1)
        if muscles or any(name.endswith((".armature", ".mass")) for name in values):
            mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def _check_sheath(self, sheath: str) -> None:
        law = {name: self.live.get(f"{sheath}.{name}", 0.0) for name in LAW}  # a servo has none
        if law["static_friction"] > 0.0:  # 0: not given, it is the dynamic one then
            check_static(law["friction"], law["static_friction"], sheath)
        check_scales(law, sheath)

    def _add(
        self,
        name: str,
        kind: Kind,
        unit: str,
        *places: _Place,
        low: float = -math.inf,
        joints: tuple[str, ...] = (),
        reference: float = 0.0,
    ) -> None:
        parameter = Parameter(_value(places), unit, kind, low, joints, reference)
        self._entries[name] = parameter, places

    def _add_joints(self) -> None:
        m = self.model
        for joint in range(m.njnt):
            name = mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint)
            if not name or m.jnt_type[joint] not in (_HINGE, _SLIDE):
                continue
            dof, place, slides = m.jnt_dofadr[joint], m.jnt_qposadr[joint], _slides(m, joint)
            for parameter, array, index, low in (
                ("stiffness", m.jnt_stiffness, joint, 0.0),
                ("damping", m.dof_damping, dof, 0.0),
                ("frictionloss", m.dof_frictionloss, dof, 0.0),
                ("armature", m.dof_armature, dof, 0.0),
            ):
                unit = JOINT[parameter][slides]
                self._add(f"{name}.{parameter}", "joint", unit, (array, index, 1.0), low=low)
            unit, reference = JOINT["springref"][slides], float(m.qpos0[place])
            spring = (m.qpos_spring, place, 1.0)
            self._add(f"{name}.springref", "joint", unit, spring, reference=reference)
            for k, (parameter, low) in enumerate(_COMMANDS.items()):
                of_column = ("-", unit, "s")[k], (self.joint_commands, (joint, k), 1.0)
                self._add(f"{name}.{parameter}", "joint", *of_column, low=low)

    def _rest_on_flanks(self) -> dict[str, int]:
        """Play of a sheath → the joint that has it, which rests on its flank."""
        model = self.model
        states = {
            name: sheath_arrays(model, self.data.plugin_state, name, sheath.state).state
            for name, sheath in sheaths(model).items()
        }
        joints = {
            f"{name}.{play}": int(state[joint])
            for name, state in states.items()
            for play, joint in _PLAYS.items()
            if int(state[joint]) >= 0
        }
        stated = {int(s["output_joint"]) for s in states.values() if s["output_play"] > 0.0}
        for name in states:
            output = joints.get(f"{name}.output_play", -1)
            if output >= 0 and output not in stated:
                self.live[f"{name}.{OUTPUT_REST}"] = _loaded_sense(model, output)
        return joints

    def _live(self, name: str, value: float) -> Parameter:
        """A parameter of a sheath or servo."""
        parameter = name.rsplit(".", 1)[1]
        if parameter == DRAWN_BEND:
            return Parameter(value, "rad", "live", 0.0)
        known = (PARAMETERS | GAINS)[parameter]
        low = 0.0 if parameter in PARAMETERS and not known.range.admits(-1.0) else -math.inf
        if name not in self._winding_joints:
            return Parameter(value, known.unit, "live", low)
        joint = self._winding_joints[name]
        unit = JOINT["springref"][_slides(self.model, joint)]
        return Parameter(value, unit, "live", low, joints=(self.model.joint(joint).name,))

    def _add_limits(self) -> None:
        m = self.model
        of_joints = m.wrap_type[m.tendon_adr] == mujoco.mjtWrap.mjWRAP_JOINT.value
        moved = np.where(of_joints, m.wrap_objid[m.tendon_adr], -1)
        kinds: tuple[Kind, Kind] = "joint", "tendon"
        for kind, of, joints, limited, ranges in zip(
            kinds,
            (_OBJ.mjOBJ_JOINT, _OBJ.mjOBJ_TENDON),
            (np.arange(m.njnt), moved),
            (m.jnt_limited, m.tendon_limited),
            (m.jnt_range, m.tendon_range),
            strict=True,
        ):
            widths = np.ptp(ranges, axis=1)
            for k in map(int, np.flatnonzero(limited & (widths > 0.0))):
                name, joint = mujoco.mj_id2name(m, of, k), int(joints[k])
                if not name:
                    continue
                unit = JOINT["springref"][joint < 0 or _slides(m, joint)]
                scaled = [(ranges, (k, end), float(ranges[k, end] / widths[k])) for end in (0, 1)]
                width = (widths, k, 1.0)
                self._add(f"{name}.{RANGE_WIDTH}", kind, unit, width, *scaled, low=0.0)
                for end, parameter in enumerate(RANGE_ENDS):
                    self._add(f"{name}.{parameter}", kind, unit, (ranges, (k, end), 1.0))

    def _add_bodies(self) -> None:
        m = self.model
        for body in range(1, m.nbody):
            name, mass = mujoco.mj_id2name(m, _OBJ.mjOBJ_BODY, body), float(m.body_mass[body])
            if not name or mass == 0.0 or m.body_weldid[body] == 0:
                continue
            inertia = m.body_inertia
            ratios = [(inertia, (body, k), float(inertia[body, k]) / mass) for k in range(3)]
            places: list[_Place] = [(m.body_mass, body, 1.0), *ratios]
            joints = self._joints_above(body)
            self._add(f"{name}.mass", "body", "kg", *places, low=mujoco.mjMINVAL, joints=joints)

    def _joints_above(self, body: int) -> tuple[str, ...]:
        """Joints that have a name and move a body, its own first."""
        m, names = self.model, list[str]()
        while body:
            first = m.body_jntadr[body]
            joints = range(first, first + m.body_jntnum[body])
            names += [mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint) or "" for joint in joints]
            body = m.body_parentid[body]
        return tuple(filter(None, names))

    def _add_actuators(self) -> None:
        m = self.model
        gain, bias = m.actuator_gainprm, m.actuator_biasprm
        for k in range(m.nactuator):
            name, joint = mujoco.mj_id2name(m, _OBJ.mjOBJ_ACTUATOR, k), joint_of(m, k)
            if not name:
                continue
            on = mujoco.mj_id2name(m, _OBJ.mjOBJ_JOINT, joint) if joint >= 0 else None
            slots: list[tuple[str, str, float, list[_Place]]] = [
                ("gear", "-", -math.inf, [(m.actuator_gear, (k, 0), 1.0), *ranges_of_gear(m, k)])
            ]
            unit, least = control_unit(m, k), dict(_COMMANDS)
            units = {"command_scale": "-", "command_offset": unit, "command_delay": "s"}
            if unit in _PLACES:
                units |= {"slip": unit, "slip_time": "s", "slip_duration": "s"}
                least["slip_duration"] = 0.0
            for number, (parameter, unit) in enumerate(units.items()):
                low = least.get(parameter, -math.inf)
                slots.append((parameter, unit, low, [(self.commands, (k, number), 1.0)]))
            if gain[k, 0] != 0.0 and gain[k, 0] == -bias[k, 1]:  # a position servo
                slides = joint < 0 or _slides(m, joint)
                stiffness: list[_Place] = [(gain, (k, 0), 1.0), (bias, (k, 1), -1.0)]
                slots.append(("kp", JOINT["stiffness"][slides], 0.0, stiffness))
                slots.append(("kv", JOINT["damping"][slides], 0.0, [(bias, (k, 2), -1.0)]))
            kind: Kind = "motor" if _is_motor(m, k) else "actuator"
            for parameter, unit, low, places in slots:
                joints = (on,) if on else ()
                self._add(f"{name}.{parameter}", kind, unit, *places, low=low, joints=joints)

    def _add_sensors(self) -> None:
        least = {"delay": 0.0, "lag": 0.0, "efficiency": ROUNDING}
        for k in range(self.model.nsensor):
            name = mujoco.mj_id2name(self.model, _OBJ.mjOBJ_SENSOR, k)
            unit = reading_unit(self.model, k)
            units = ("-", unit, "s", "s", rate(unit), "-", "-", "-")
            for column, parameter in enumerate(Readout._fields):
                if name and (parameter not in GEARED or k in self.geared):
                    place = (self.readings, (k, column), 1.0)
                    low = least.get(parameter, -math.inf)
                    self._add(f"{name}.{parameter}", "sensor", units[column], place, low=low)


def has_soft_friction(model: mujoco.MjModel, joint: str) -> bool:
    """Return whether a joint has dry friction with MuJoCo's own softness."""
    dof = model.joint(joint).dofadr[0]
    return bool(model.dof_frictionloss[dof] > 0.0 and np.all(model.dof_solimp[dof] == _SOFT_SOLIMP))


def stiff_friction(model: mujoco.MjModel) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """`solref` and `solimp` of dry friction that sticks."""
    return (2.0 * model.opt.timestep, 1.0), _STIFF_SOLIMP  # MuJoCo's least time constant


def _stiffen_friction(model: mujoco.MjModel) -> None:
    """Let joints without dry friction stick if they are given some, unless the model says how."""
    solref, solimp = stiff_friction(model)
    none = model.dof_frictionloss == 0.0
    model.dof_solref[none & np.all(model.dof_solref == _SOFT_SOLREF, axis=1)] = solref
    model.dof_solimp[none & np.all(model.dof_solimp == _SOFT_SOLIMP, axis=1)] = solimp


def _loaded_sense(model: mujoco.MjModel, joint: int) -> float:
    """Sense in which gravity and springs load a joint in the reference pose, or 0."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    dof = model.jnt_dofadr[joint]
    load = float(data.qfrc_spring[dof] + data.qfrc_gravcomp[dof] - data.qfrc_bias[dof])
    return float(np.sign(load)) if abs(load) > ROUNDING else 0.0


def _slides(model: mujoco.MjModel, joint: int) -> bool:
    return bool(model.jnt_type[joint] != _HINGE)


def joint_of(model: mujoco.MjModel, actuator: int) -> int:
    """The joint that an actuator is on, or −1."""
    on_joint = model.actuator_trntype[actuator] in _ON_JOINT
    return int(model.actuator_trnid[actuator, 0]) if on_joint else -1


def _is_motor(model: mujoco.MjModel, actuator: int) -> bool:
    return bool(
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED.value
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE.value
        and model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE.value
        and model.actuator_plugin[actuator] < 0
    )


def _geared(model: mujoco.MjModel, data: mujoco.MjData) -> dict[int, dict[int, float]]:
    """`Adjustable.geared`, of sensors of T_in and of actuators' forces."""
    states = [
        sheath_arrays(model, data.plugin_state, name, sheath.state).state
        for name, sheath in sheaths(model).items()
    ]
    sheath_of = {int(state["tendon"]): state for state in states}

    places = [k for k in range(model.nactuator) if control_unit(model, k) in _PLACES]

    def senses(sensor: int) -> dict[int, float]:
        if model.sensor_type[sensor] == mujoco.mjtSensor.mjSENS_ACTUATORFRC.value:
            return {k: 1.0 for k in places if k == model.sensor_objid[sensor]}
        if not sheath_of or sensor_kind(model, sensor) != "input_tension":
            return {}
        state = sheath_of.get(_shown_tendon(model, sensor))
        return {} if state is None else {k: _winding(model, k, state) for k in places}

    geared = {s: {k: way for k, way in senses(s).items() if way} for s in range(model.nsensor)}
    return {sensor: by for sensor, by in geared.items() if by}


def _winding(model: mujoco.MjModel, actuator: int, state: NDArray[np.void]) -> float:
    """Sense in which a control winds in the tendon of a sheath; 0 if it does not."""
    joint, gear = joint_of(model, actuator), model.actuator_gear[actuator, 0]
    if actuator == int(state["reel_actuator"]):
        return float(np.sign(gear))
    reel = int(state["reel_joint"])
    if joint >= 0 and joint == reel:
        return float(np.sign(gear * state["reel_radius"]))
    pulls = model.actuator_trntype[actuator] == _TRN.mjTRN_TENDON.value
    on_it = pulls and model.actuator_trnid[actuator, 0] == int(state["tendon"])
    return -float(np.sign(gear)) if on_it and model.actuator_plugin[actuator] < 0 else 0.0


def _shown_tendon(model: mujoco.MjModel, sensor: int) -> int:
    """The tendon whose sheath a sensor shows, by its object or by its instance."""
    if model.sensor_objtype[sensor] == _OBJ.mjOBJ_TENDON.value:
        return int(model.sensor_objid[sensor])
    instance = int(model.sensor_plugin[sensor])
    written = C.mj_getPluginConfig(model._address, instance, b"tendon") or b""
    return int(mujoco.mj_name2id(model, _OBJ.mjOBJ_TENDON, written.decode()))


def _value(places: tuple[_Place, ...]) -> float:
    array, index, factor = places[0]
    return float(array[index]) * factor + 0.0  # + 0: no negative zero


def _check(name: str, low: float, value: float) -> None:
    low = max(low, -LARGEST)
    if not low <= value <= LARGEST:
        raise InvalidValueError(f"{name} = {value:g} is outside {low:g} … {LARGEST:g}")


def is_muscle(model: mujoco.MjModel, actuator: int) -> bool:
    """Return whether an actuator's force is a muscle's, of its length and speed."""
    return bool(
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_MUSCLE.value
        or model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_MUSCLE.value
    )


def ranges_of_gear(
    model: mujoco.MjModel, actuator: int
) -> list[tuple[NDArray[np.float64], tuple[int, int], float]]:
    """Both ends of a muscle's range of lengths: array, index, and length of a gear of 1 [m].

    None of another actuator, and of a muscle whose gear is 0.
    """
    gear, ends = float(model.actuator_gear[actuator, 0]), model.actuator_lengthrange
    if not is_muscle(model, actuator) or gear == 0.0:
        return []
    return [(ends, (actuator, k), float(ends[actuator, k]) / gear) for k in range(2)]
