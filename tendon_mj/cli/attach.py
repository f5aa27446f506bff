"""`tendon-mj attach`, `parameters`, `library`: MJCF files, and plugins for other programs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import tyro

from tendon_mj.attach import Attached, Row, attach_cable_drives, attach_friction
from tendon_mj.cli.options import OutFile, Repeated, flat
from tendon_mj.cli.output import console, print_table
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.parameter_names import matching
from tendon_mj.lab.replay import Adjustable, Parameter
from tendon_mj.models import load_model, load_spec, model_path
from tendon_mj.plugin import export_library

_ATTACHED_HEAD = (
    *("tendon", "bend [rad]", "over ranges", "e^(-μφ), least"),
    *("EA [N]", "drive", "input end", "done"),
)


def attach(
    model: tyro.conf.Positional[str],
    friction: float,
    out: OutFile[Path],
    tendon: Repeated[str] = (),
    actuator: Repeated[str] = (),
    radius: float | None = None,
    efficiency: float = 1.0,
    servo: Path | None = None,
    servo_gain: float = 0.0,
    servo_voltage: float = 0.0,
    motor: bool = False,
    length: float | None = None,
    armature: float | None = None,
    axial_stiffness: float | None = None,
    pretension: float | None = None,
    arc_guides: int = 1,
    inner_guides: int | None = None,
    input_end: Literal["first", "last"] = "first",
    extra_bend: float = 0.0,
) -> Attached:
    """Add sheaths to the tendons of a model, and write it with a table of their bends and losses.

    Give --tendon, or --actuator for cables that the model does not draw.

    Args:
        model: MJCF file, or a model of the package: bench, joint, finger, finger_spring.
        friction: Friction coefficient mu of the sheaths.
        out: MJCF file to write.
        tendon: Names of spatial tendons, or patterns such as "*" or "flex*", in quotes.
        actuator: Names or patterns of actuators on joints or fixed tendons, which cables turn that
            bend by --extra-bend and run on drums of --radius.
        radius: Radius of the drums in m, with --actuator.
        efficiency: With --actuator, share of its torque that a gear before each cable passes on.
        servo: With --actuator, JSON file of BAM with the friction and inertia of a servo. With
            --friction 0 it needs no --radius and no --extra-bend, as there is no cable behind it.
        servo_gain: Gain of the servo from angle to voltage in V/rad, with --servo. With
            --servo-voltage the actuators become the motors of the file.
        servo_voltage: Largest voltage of the servo in V, with --servo.
        motor: With --actuator, give each joint a motor with a joint of its own, on which its
            actuators act, and cables of --axial-stiffness and --length, by which motion is lost.
        length: Length of the cables in m, with --motor.
        armature: Inertia of each motor at its joint in kg m², with --motor. By default the joint's
            armature, which moves to the motor.
        axial_stiffness: Axial stiffness EA in N. By default a tendon that an actuator pulls is as
            stiff as the time step resolves, and any other is as stiff as its own spring.
        pretension: Pretension T_0 in N, where no actuator pulls. By default the pull of its own
            spring. With --actuator that of both cables of a joint, by default 0.
        arc_guides: Guides on each geom that a tendon may wrap around.
        inner_guides: Guides at the input end, at which --extra-bend acts. By default one where the
            drawn path has no guide, else none.
        input_end: End of each tendon that is pulled. Give last for tendons whose path is listed
            from the insertion to the muscle or motor.
        extra_bend: Bend that the drawn path does not show.

    Example:
        tendon-mj attach hand.xml --tendon "flex*" --friction 0.15 --out hand_mu.xml
    """
    if bool(flat(tendon)) == bool(flat(actuator)):
        raise InvalidValueError("give --tendon or --actuator: a name, several, or a pattern")
    source = model_path(model)
    if flat(actuator):
        if servo and not motor and radius is None and not extra_bend and not friction:
            radius, extra_bend = 1.0, 1.0  # a drum that turns newtons to newton metres
        if radius is None or not extra_bend:
            raise InvalidValueError(
                "--actuator takes --radius [m] and --extra-bend [rad] of a cable that is not drawn"
            )
        cable: dict[str, Any] = {"radius": radius, "bend": extra_bend, "friction": friction}
        cable |= {"pretension": pretension or 0.0, "axial_stiffness": axial_stiffness}
        cable |= {"servo": servo, "servo_gain": servo_gain, "servo_voltage": servo_voltage}
        cable |= {"efficiency": efficiency, "motor": motor, "length": length, "armature": armature}
        return _attach_cables(source, flat(actuator), out, cable)
    of_servo = servo or servo_gain or servo_voltage
    if motor or of_servo or (radius, length, armature, efficiency) != (None, None, None, 1.0):
        raise InvalidValueError(
            "--radius, --efficiency, --servo, --motor, --length and --armature belong to"
            " --actuator: a tendon that is drawn has its own"
        )
    attached = attach_friction(
        load_spec(str(source)),
        source,
        flat(tendon),
        out,
        friction=friction,
        axial_stiffness=axial_stiffness,
        pretension=pretension,
        arc_guides=arc_guides,
        inner_guides=inner_guides,
        input_end=input_end,
        extra_bend=extra_bend,
    )
    print_table(_ATTACHED_HEAD, [_row_cells(row) for row in attached.rows])
    for text in _remarks(attached):
        console.print(text)
    console.print(f"wrote {attached.path}")
    console.print(_most_loss_sentence(attached.rows))
    return attached


def _attach_cables(
    source: Path, actuator: Sequence[str], out: Path, cable: dict[str, Any]
) -> Attached:
    """Give actuators cables that are not drawn, and say what these lose."""
    attached = attach_cable_drives(load_spec(str(source)), source, actuator, out, **cable)
    for text in attached.said:
        console.print(text)
    passed = math.exp(-cable["friction"] * cable["bend"])
    held = 2.0 * cable["pretension"] * cable["friction"] * cable["bend"]
    console.print(f"wrote {attached.path}")
    share = cable["efficiency"]
    gear = f" ({share * passed:.3f} with the gear)" if share < 1.0 else ""
    if passed < 1.0:
        console.print(
            f"Each cable passes on {passed:.3f} of its tension{gear}, and loses {held:.3g} N at"
            f" least, {held * cable['radius']:.3g} N m at its drum."
        )
    return attached


def _remarks(attached: Attached) -> Iterator[str]:
    if any(row.sheath and row.axial_stiffness is None for row in attached.rows):
        yield "the step's EA: as stiff as the model's step resolves"
    too_stiff = [
        f"{row.tendon} ({row.axial_stiffness:.4g} N, where {row.largest_stiffness:.2g} N would do)"
        for row in attached.rows
        if row.axial_stiffness and row.axial_stiffness > row.largest_stiffness
    ]
    if too_stiff:
        yield (
            f"EA above the largest for this time step at qpos0: {', '.join(too_stiff)}. Where an "
            "actuator pulls, the guides yield instead; any other tendon may ring from step to "
            "step: take a shorter step"
        )
    branched = [row.tendon for row in attached.rows if row.sheath and row.has_pulleys]
    if branched:
        yield (
            f"over pulleys, bend and loss are those of the most bent branch: {', '.join(branched)}."
            " Views and clips show its ends; the sensor output_tension shows the end of the last "
            "branch"
        )
    for row in attached.rows:
        yield from row.idlers
    yield from attached.limits
    yield from attached.said


def _most_loss_sentence(rows: Sequence[Row]) -> str:
    sheathed = [row for row in rows if row.sheath]
    if not sheathed:
        return "No tendon runs in a sheath: the last column says why."
    is_alone = len(rows) == 1
    count = f"{len(sheathed)} of {len(rows)} tendons run in sheaths"
    if is_alone:
        count = f"{rows[0].tendon} runs in a sheath"
    slipping = [row for row in sheathed if row.acts and row.most_slid_bend > 0.0]
    if not slipping:
        return f"{count}; no joint feels sliding friction in the poses that were searched."
    if not any(row.friction for row in slipping):
        return f"{count}; friction = 0: none of them loses a share of its tension."
    most = min(slipping, key=lambda row: row.least_transmission)
    now, worst = f"{1.0 - most.transmission:.0%}", f"{1.0 - most.least_transmission:.0%}"
    loses = f"{count}; {most.tendon} loses most by friction, {now} of its tension"
    if is_alone:
        loses = f"{count}, and loses {now} of its tension by friction"
    if now == worst:
        return f"{loses}, at qpos0 as in the worst of the poses that its joints allow."
    return (
        f"{loses} at qpos0 and up to {worst} in the poses that its joints allow, where it bends by "
        f"{most.least_bend:.2f} to {most.most_bend:.2f} rad."
    )


def _row_cells(row: Row) -> tuple[str, ...]:
    default = "the step's" if row.sheath else "-"
    return (
        row.tendon,
        f"{row.bend:.2f}",
        f"{row.least_bend:.2f} … {row.most_bend:.2f}",
        f"{row.transmission:.3f}, {row.least_transmission:.3f}" if row.acts else "-",
        default if row.axial_stiffness is None else f"{row.axial_stiffness:.4g}",
        row.drives,
        row.input or "-",
        row.done,
    )


def parameters(model: tyro.conf.Positional[str], name: str = "*") -> dict[str, Parameter]:
    """List the parameters of a model that recordings, sweeps and changes can name.

    Args:
        model: MJCF file, or a model of the package: bench, joint, finger, finger_spring.
        name: Pattern of the names to list, in quotes.

    Example:
        tendon-mj parameters finger --name "flexor_sheath.*"
    """
    known = Adjustable(load_model(model)).parameters()
    listed = {one: known[one] for one in matching(name, known) if one in known}
    if not listed:
        raise UnknownNameError("parameter", name, known, "--name")
    rows = [(one, f"{found.value:.6g}", found.unit) for one, found in listed.items()]
    print_table(("parameter", "value", "unit"), rows)
    return listed


def library(out: Path = Path("mujoco_plugin")) -> Path:
    """Write the library of the plugins, and a header of their attributes, for C, C++ and ROS 2.

    Args:
        out: Folder for libtendon_mj.so (.dylib on macOS) and tendon_mj.h. MuJoCo's own `simulate`
            loads the libraries of a folder mujoco_plugin next to its executable.

    Example:
        tendon-mj library --out mujoco_plugin
    """
    written = export_library(out)
    console.print(f"{written} for MuJoCo 3.11 to 4.0, and {written.with_name('tendon_mj.h')}")
    return written
