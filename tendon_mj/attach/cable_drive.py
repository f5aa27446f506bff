"""Cables that are not drawn, between the actuators of a model and the joints that they turn."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, SupportsFloat, Unpack

import mujoco

from tendon_mj.attach import bam, instances, tendons
from tendon_mj.attach.attachment import Attached, changing
from tendon_mj.attach.friction import add_sheaths, joint_warnings, listed_reasons
from tendon_mj.attach.keywords import check_names, checked_number, takes
from tendon_mj.attach.mjcf import write_sheaths
from tendon_mj.attach.motor import ON_JOINT, Motor, actuators_on, add_motors, switch_off
from tendon_mj.attach.sheath_design import NewSheath
from tendon_mj.attach.stiffness_limit import drums_warning
from tendon_mj.errors import InvalidValueError, TendonWarning, UnsuitedTendonError
from tendon_mj.sheath import LAW, Law, OptionalParameters, doubt_of_unit

_TRN, _JOINT = mujoco.mjtTrn, mujoco.mjtJoint
_LAW = {name: parameter for name, parameter in LAW.items() if name != "extra_bend"}
_STIFF = {
    *("friction", "static_friction", "constant_friction", "pretension", "extra_bend"),
    *("stribeck_friction", "stribeck_velocity", "direction_asymmetry"),
    "friction_drift",
}


class CableDrive(NamedTuple):
    """A cable between actuators and the joints that they turn."""

    tendon: str  # fixed, whose length its drums turn by
    joint: str  # that it turns, where the tendon has to be added; else empty
    radius: float  # of the drums [m]


@takes(_LAW)
def add_cable_drive(
    spec: mujoco.MjSpec,
    actuator: str | Sequence[str],
    *,
    radius: SupportsFloat,
    bend: SupportsFloat,
    friction: SupportsFloat,
    pretension: SupportsFloat = 0.0,
    efficiency: SupportsFloat = 1.0,
    back_efficiency: SupportsFloat | None = None,
    servo: str | Path | None = None,
    servo_gain: SupportsFloat = 0.0,
    servo_voltage: SupportsFloat = 0.0,
    motor: bool = False,
    axial_stiffness: SupportsFloat | None = None,
    length: SupportsFloat | None = None,
    armature: SupportsFloat | None = None,
    sensors: Sequence[str] = ("input_tension", "output_tension"),
    **parameters: Unpack[OptionalParameters],
) -> mujoco.MjSpec:
    """Let actuators turn their joints by cables with friction that the model does not draw.

    Actuators, joints, controls and keyframes stay as they are: friction takes its share of the
    force that arrives at a joint, and holds it at rest. The cable of a joint belongs to a fixed
    tendon ``<joint>_cable`` that is added, and has the force of all actuators on the joint; an
    actuator on a fixed tendon keeps that. Two cables pull, one each way. With a pretension, the
    loss is at least that of both cables under it; without one, the other cable is slack. Nothing
    stretches, so there is no lost motion.

    With ``motor``, the actuators of a joint turn a joint ``<joint>_motor`` that is added behind all
    others, on a body of its own, and two elastic cables, the spatial tendons ``<joint>_cable`` and
    ``<joint>_cable_back``, turn the joint. A servo then measures its motor, and motion is lost.

    Args:
        spec: changed in place and returned; not at all if the call is refused.
        actuator: name of an actuator on a hinge, a slide or a fixed tendon, several names, or a
            pattern such as ``*``, which leaves out other actuators; a warning says which.
        radius: of the drum on a joint [m]; for a fixed tendon, of cable per unit of its
            coefficients' sum. Of a slide 1 is taken. It gives tensions their newtons, and has no
            part in the share that is lost.
        bend: whole angle by which the cable turns on its way [rad].
        <parameters>
        efficiency: η_f of a gear between the actuators and the cable while they drive, whose
            friction grows with the load behind it.
        back_efficiency: η_b while the load drives them, by default 2 − 1/η_f, that of a gear whose
            friction does not depend on which side drives. At 0 or less the gear locks itself.
        servo: JSON file of BAM, models M1 to M6. Its friction is in the place of a gear's, and its
            armature and viscous friction in that of the armature, damping and frictionloss of each
            joint.
        servo_gain: proportional gain of its firmware [V/rad]. The actuators become DC motors with
            the file's motor constant and resistance, whose controls are angles.
        servo_voltage: largest voltage that it gives its motor [V], required with ``servo_gain``.
        motor: whether the actuators are to turn motors; parameters of cables that stretch, such as
            ``axial_stiffness``, which is then required, are for these. ``axial_damping`` is by
            default EA times the time step, against ringing.
        length: of a motor's cables [m], required with it.
        armature: of a motor at its joint [kg m²], by default that of the joint. It moves there.
        sensors: kinds to add, named ``<tendon>_<kind>``. The tension is the difference of both
            cables, and above 0 if it turns the joint towards positive angles; a motor's cables
            have their own.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such actuator, parameter or sensor kind, with the nearest name.
        InvalidValueError: a parameter outside its range; an actuator given by its name that turns
            no joint by a cable, or whose cable is there already; a pattern that means no other.

    Warns:
        TendonWarning: of a friction above 2, of a bend above four turns, of one that no force of
            the actuators overcomes, of actuators that were left out, and of what limits or senses
            a joint's force behind the cable's back.
    """
    tendons.check_spec(spec)
    check_names(_LAW, parameters, "add_cable_drive")
    instances.check_kinds(sensors)
    of_motor = {"axial_stiffness": axial_stiffness, "length": length, "armature": armature}
    needed: dict[str, Any] = {"radius": radius, "bend": bend, "friction": friction}
    given = {"pretension": pretension, **of_motor, **parameters}
    needed |= {k: v for k, v in given.items() if v is not None}
    values = {k: checked_number(k, v) for k, v in needed.items()}
    _check_form(spec, values, motor)
    gear = _gear(checked_number("efficiency", efficiency), back_efficiency)
    volts = [checked_number("servo_gain", servo_gain)]
    volts.append(checked_number("servo_voltage", servo_voltage))
    numbers = _servo(servo, gear, *volts)
    sizes = {k: values.pop(k) for k in ["radius", "length", "armature"] if k in values}
    law = Law(**{"axial_stiffness": 1.0, "extra_bend": values.pop("bend")} | values)
    drives, left_out = _design_all(spec, actuator, sizes["radius"], motor or numbers is not None)
    if numbers:
        gear = numbers.friction
        _put_servo(spec, drives, numbers, motor)
    held = _held(spec, drives, law, gear)
    if motor:
        damping = numbers.damping if numbers else 0.0
        motors = [_motor(spec, drive, sizes, law, damping) for drive in drives]
        cables = _motor_cables(spec, motors, law)
        behind = _gears(spec, cables) if gear else []
        new = cables + [_stiff_sheath(spec, one, {"friction": "0.0"} | gear) for one in behind]
    else:
        config = {k: v for k, v in _stated(law).items() if k in _STIFF} | gear
        cables, new = [], [_stiff_sheath(spec, drive, config) for drive in drives]
    add_sheaths(spec, new, None, None, sensors, alone=False)
    stiff = ""
    if motor:
        drums, by_step = _drums(cables, sizes["length"]), "axial_damping" not in parameters
        stiff = drums_warning(spec.compile(), drums, law, damped_by_step=by_step)
    stated = {**values, "extra_bend": law.extra_bend}
    doubts = [doubt_of_unit(name, value) for name, value in stated.items()]
    left = [f"left as they are: {listed_reasons(left_out)}"] if left_out else []
    joints = [joint for sheath in new for joint in _turned(spec, sheath)]
    more = joint_warnings(spec, [sheath for sheath in new if sheath.is_driven])
    more += [_unsensed(spec, joints)] if motor else [_locking(gear)]
    for message in filter(None, [*doubts, held, *left, *more, stiff, _weightless(joints)]):
        warnings.warn(f"add_cable_drive: {message}", TendonWarning, stacklevel=2)
    return spec


def _check_form(spec: mujoco.MjSpec, values: dict[str, float], motor: bool) -> None:
    """Refuse sizes that no cable has, and what belongs to a motor without one or the reverse."""
    for name, unit in (("radius", "m"), ("bend", "rad"), ("length", "m"), ("armature", "kg m²")):
        if not 0.0 < values.get(name, 1.0) < math.inf:
            raise InvalidValueError(f"{name} = {values[name]:g} [{unit}] must be finite and > 0")
    bounds = (spec.compiler.boundmass, spec.compiler.boundinertia)
    if motor and any(bounds):
        raise InvalidValueError(
            f"motor=True: the compiler's boundmass = {bounds[0]:g} and boundinertia ="
            f" {bounds[1]:g} would be the motor's, too: set them to 0, and masses on bodies"
        )
    if not motor:
        for name in values.keys() - _STIFF - {"radius", "bend"}:
            raise InvalidValueError(
                f"{name!r} = {values[name]:g} belongs to a motor with cables that stretch: give "
                "motor=True, or leave it out"
            )
        return
    for name, unit in (("axial_stiffness", "N"), ("length", "m")):
        if name not in values:
            raise InvalidValueError(
                f"motor=True needs {name} [{unit}] of the cables, by which motion is lost"
            )
    values.setdefault("axial_damping", values["axial_stiffness"] * float(spec.option.timestep))


def _gear(efficiency: float, back_efficiency: SupportsFloat | None) -> dict[str, str]:
    """Attributes of a gear: its friction over the load behind it; none without a loss."""
    if not 0.0 < efficiency <= 1.0:
        raise InvalidValueError(f"efficiency = {efficiency:g} must be > 0 and ≤ 1")
    gear = {"gear_friction": 1.0 / efficiency - 1.0}
    if back_efficiency is not None:
        back = checked_number("back_efficiency", back_efficiency)
        if not -math.inf < back < 1.0:
            raise InvalidValueError(f"back_efficiency = {back:g} must be finite and < 1")
        gear["gear_friction_back"] = 1.0 - back
    return {k: repr(v) for k, v in gear.items() if v}


def _held(
    spec: mujoco.MjSpec, drives: Sequence[CableDrive], law: Law, gear: Mapping[str, str]
) -> str:
    """Warning of cables whose friction under their pretension no force of their actuators ends."""
    holds = 2.0 * law.pretension * law.friction * law.extra_bend
    holds *= 1.0 + float(gear.get("gear_friction", "0.0"))
    pulls = dict[str, float]()
    for drive in drives:
        on = spec.joint(drive.joint) if drive.joint else spec.tendon(drive.tendon)
        actuators = [a for a in spec.actuators if a.target == on.name]
        ranges = [tendons.force_range(actuator, on) or (-math.inf,) for actuator in actuators]
        most = sum(max(map(abs, each)) for each in ranges) / drive.radius
        pulls |= {actuators[0].name or on.name: most} if most < holds else {}
    if not pulls:
        return ""
    return (
        f"actuator {tendons.listed(pulls)} can pull with {min(pulls.values()):.3g} N at most, and"
        f" two cables under a pretension of {law.pretension:g} N hold {holds:.3g} N by friction, so"
        " that nothing moves: the radius is in m, the bend in rad"
    )


def _locking(gear: Mapping[str, str]) -> str:
    """Warning of a gear that locks itself, without a motor of its own."""
    back = 1.0 - float(gear.get("gear_friction_back", gear.get("gear_friction", "0.0")))
    if back > 0.0:
        return ""
    return (
        f"a gear with a back efficiency of {back:g} locks itself: where its joint meets a contact,"
        " a limit or an equality, whose force acts one step late, it pushes on without bound:"
        " give motor=True if it may meet one"
    )


def _stiff_sheath(spec: mujoco.MjSpec, drive: CableDrive, stated: Mapping[str, str]) -> NewSheath:
    """The sheath of a cable that does not stretch, on the fixed tendon of its joint."""
    element = spec.tendon(drive.tendon) if not drive.joint else _add_cable(spec, drive)
    config = {"guides": "1", "inner_guides": "1", "radius": repr(drive.radius), **stated}
    return NewSheath(element, drive.tendon, config, is_driven=True)


def _gears(spec: mujoco.MjSpec, cables: Sequence[NewSheath]) -> list[CableDrive]:
    """Drives of gears between motors and their actuators."""
    taken = {tendon.name for tendon in spec.tendons}
    drives = []
    for config in (cable.config for cable in cables[::2]):
        name = instances.take_name(taken, f"{config['output_joint']}_gear")
        drives.append(CableDrive(name, config["reel_joint"], float(config["reel_radius"])))
    return drives


def _motor_cables(spec: mujoco.MjSpec, motors: Sequence[Motor], law: Law) -> list[NewSheath]:
    """The sheaths of cables that stretch, two for each motor."""
    return [
        NewSheath(tendon, tendon.name, config | _stated(law), is_driven=False)
        for tendon, config in add_motors(spec, motors)
    ]


def _drums(sheaths: Sequence[NewSheath], length: float) -> list[tuple[str, float]]:
    """Joints of motors' cables, as `drums_warning` asks for them."""
    drums = []
    for config in (sheath.config for sheath in sheaths):
        for end in ("reel", "output"):
            squared = float(config[f"{end}_radius"]) ** 2
            drums.append((config[f"{end}_joint"], squared * 2 * int(config["guides"]) / length))
    return drums


def _stated(law: Law) -> dict[str, str]:
    """Attributes of a law's parameters that are not 0, and friction."""
    return {k: repr(v) for k, v in dataclasses.asdict(law).items() if v or k == "friction"}


def _servo(
    source: str | Path | None, gear: Mapping[str, str], gain: float, voltage: float
) -> bam.Servo | None:
    """The servo of a file; refused beside another gear, as is a voltage without one."""
    if source is None:
        if gain or voltage:
            raise InvalidValueError(
                f"servo_gain = {gain:g} and servo_voltage = {voltage:g} need servo, a JSON file of"
                " BAM with the constant and resistance of a motor"
            )
        return None
    if gear:
        raise InvalidValueError(
            f"servo = '{source}' has the friction of its gear: leave out efficiency and"
            " back_efficiency, or servo"
        )
    return bam.read_servo(source, gain, voltage)


def _put_servo(
    spec: mujoco.MjSpec, drives: Sequence[CableDrive], servo: bam.Servo, motor: bool
) -> None:
    """Make actuators those of a servo, and give joints its numbers; a ``motor`` has its damping."""
    if servo.gain:
        actuators = [a for drive in drives for a in actuators_on(spec, drive.joint)]
        bam.control_by_voltage(spec, actuators, servo)
    for drive in drives:
        joint = spec.joint(drive.joint)
        joint.armature, joint.frictionloss = servo.armature, 0.0
        joint.damping = [0.0 if motor else servo.damping, 0.0, 0.0]
        joint.springdamper = [0.0, 0.0]  # which would be a damping of its own


def _motor(
    spec: mujoco.MjSpec, drive: CableDrive, sizes: Mapping[str, float], law: Law, damping: float
) -> Motor:
    """The motor of a drive, whose armature is by default that of its joint."""
    armature = sizes.get("armature", float(spec.joint(drive.joint).armature))
    if not armature > 0.0:
        raise InvalidValueError(
            f"joint {drive.joint!r} has no armature for its motor: give armature [kg m²], that of "
            "rotor and gear at the joint"
        )
    return Motor(drive.joint, drive.radius, sizes["length"], armature, law, damping)


def _turned(spec: mujoco.MjSpec, sheath: NewSheath) -> list[mujoco.MjsJoint]:
    """Joints that a cable turns."""
    if sheath.is_driven:
        return tendons.crossed_joints(sheath.tendon)
    return [spec.joint(sheath.config["output_joint"])]


def _weightless(joints: Sequence[mujoco.MjsJoint]) -> str:
    """Warning of joints whose actuators bear the weight of bodies without a command."""
    names = dict.fromkeys(joint.name for joint in joints if joint.actgravcomp)
    if not names:
        return ""
    return (
        f"actuatorgravcomp of joint {tendons.listed(names)} bears weight there past the cable, "
        "which does not rub under it: turn it off, and let the control bear that"
    )


def _unsensed(spec: mujoco.MjSpec, joints: Sequence[mujoco.MjsJoint]) -> str:
    """Warning of sensors of actuators that now turn motors."""
    sensed = tendons.force_sensors(spec, [joint.name for joint in joints])
    if not sensed:
        return ""
    return (
        f"sensor {tendons.listed(sensed)} (jointactuatorfrc) reads 0, as no actuator acts on its "
        "joint now: let it read the joint's motor"
    )


def attach_cable_drives(
    spec: mujoco.MjSpec, source: Path, actuator: Sequence[str], path: Path, **cable: Any
) -> Attached:
    """Give actuators of a model cables, and write the model as a new file.

    ``spec`` was read from ``source``, and is changed; ``cable`` are options of `add_cable_drive`.
    Raises `TendonError` where it or MuJoCo refuse the model, or the file cannot be written.
    """
    with changing(source, "add_cable_drive") as said:
        add_cable_drive(spec, actuator, **cable)
        write_sheaths(source, spec, path)
    return Attached(path, (), tuple(said), ())


def _design_all(
    spec: mujoco.MjSpec, actuator: str | Sequence[str], radius: float, motor: bool
) -> tuple[list[CableDrive], dict[str, str]]:
    """Cable drives that a call adds; actuators that a pattern leaves out → why."""
    chosen = tendons.choose(list(spec.actuators), actuator, "actuator")
    sheathed = instances.sheaths_by_tendon(spec)
    turned = {joint: t for t in sheathed if (joint := tendons.only_joint(spec.tendon(t)))}
    taken = {tendon.name for tendon in spec.tendons}
    drives: dict[tuple[mujoco.mjtTrn, str], CableDrive] = {}
    left_out: dict[str, str] = {}
    for element, name, by_name in chosen:
        on = element.trntype if element.trntype not in ON_JOINT else _TRN.mjTRN_JOINT
        if (on, element.target) in drives:
            continue
        try:
            drive = _design(spec, element, radius)
            turns = drive.joint or tendons.only_joint(spec.tendon(drive.tendon))
            cable = drive.tendon if drive.tendon in sheathed else turned.get(turns)
            if cable in sheathed:
                raise UnsuitedTendonError(
                    f"has a cable already, in sheath {sheathed[cable].name!r}"
                )
            if cable:
                raise UnsuitedTendonError(
                    f"turns joint {turns!r}, as cable {cable!r} does, and friction would count"
                    " twice"
                )
            if motor and not drive.joint:
                raise UnsuitedTendonError(
                    "turns joints by a fixed tendon, and a motor turns one: give it a cable of its"
                    " own, without motor"
                )
        except UnsuitedTendonError as error:
            if by_name:
                raise InvalidValueError(f"actuator {name!r} {error}") from None
            left_out[name] = str(error)
            continue
        if drive.joint:
            drive = drive._replace(tendon=instances.take_name(taken, drive.tendon))
        drives[on, element.target] = drive
        turned |= {turns: drive.tendon} if turns else {}
    if not drives:
        raise InvalidValueError(
            f"none of the actuators matching {tendons.listed(actuator)} can have a cable drive:"
            f" {listed_reasons(left_out)}"
        )
    return list(drives.values()), left_out


def _design(spec: mujoco.MjSpec, actuator: mujoco.MjsActuator, radius: float) -> CableDrive:
    """The drive of an actuator, on the tendon that its joint has or will have."""
    if actuator.trntype == _TRN.mjTRN_TENDON:
        tendon = spec.tendon(actuator.target)
        if tendons.path_of(tendon).is_spatial:
            raise UnsuitedTendonError(
                f"pulls tendon {tendon.name!r}, which is drawn: give that friction by add_friction"
            )
        return CableDrive(tendon.name, "", radius)
    if actuator.trntype not in ON_JOINT:
        raise UnsuitedTendonError("acts on neither a joint nor a tendon, so no cable turns a drum")
    joint = spec.joint(actuator.target)
    if joint.type not in (_JOINT.mjJNT_HINGE, _JOINT.mjJNT_SLIDE):
        raise UnsuitedTendonError(
            f"acts on joint {joint.name!r}, which is no hinge or slide, so that no drum turns it"
        )
    own = 1.0 if joint.type == _JOINT.mjJNT_SLIDE else radius
    for _, config in instances.instances(spec):
        if joint.name in (config.get("reel_joint"), config.get("output_joint")):
            return CableDrive(config.get("tendon", ""), "", own)
    return CableDrive(f"{joint.name}_cable", joint.name, own)


def _add_cable(spec: mujoco.MjSpec, drive: CableDrive) -> mujoco.MjsTendon:
    """Add the fixed tendon of a joint; nothing of it follows from the model's defaults."""
    tendon = spec.add_tendon(name=drive.tendon)
    tendon.wrap_joint(drive.joint, 1.0)
    switch_off(tendon)
    return tendon
