"""What the charts beside a clip show: forces, tensions, joint angles and controls over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from matplotlib.colors import to_hex

from tendon_mj.engine import sheaths
from tendon_mj.replay.frames import Array, Frames
from tendon_mj.view.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
)

Style = Literal["-", "--"]
_MANY = (BLUE, VERMILLION, GREEN, PURPLE)  # of tendons that the model leaves grey
_OTHERS = (GREEN, PURPLE, ORANGE, SKY)  # of joints, apart from the colours of two tendons
_MOST = 4  # lines of one kind in a chart
_UNCOLOURED = (0.5, 0.5, 0.5)  # MuJoCo's own colour of a tendon


@dataclass(frozen=True)
class Line:
    """A line of a chart.

    Attributes:
        name: of it in the legend; empty for a line that another one's entry stands for.
        values: (frames,).
        colour, style: of matplotlib.
    """

    name: str
    values: Array
    colour: str
    style: Style = "-"


@dataclass(frozen=True)
class Chart:
    """Lines over time with one axis.

    Attributes:
        label: of the axis, with its unit.
        lines: in the order of the legend.
        twin: lines of the frictionless twin, in grey behind the others.
    """

    label: str
    lines: tuple[Line, ...]
    twin: tuple[Line, ...] = ()


def tendon_colours(model: mujoco.MjModel) -> dict[str, str]:
    """Colour of the tendon of every sheath: the model's own, else one of four in turn."""
    found = {}
    for k, (name, sheath) in enumerate(sheaths(model).items()):
        rgb = model.tendon_rgba[model.tendon(sheath.tendon).id, :3]
        drawn = not np.allclose(rgb, _UNCOLOURED)
        found[name] = to_hex(rgb) if drawn else _MANY[k % len(_MANY)]
    return found


def charts(model: mujoco.MjModel, frames: Frames, twin: Frames | None = None) -> list[Chart]:
    """Charts of what there is, the most telling first.

    Args:
        model: of the frames.
        frames: of the clip.
        twin: the same motion without friction.
    """
    found = [_forces(model, frames, twin), _tensions(model, frames), _joints(model, frames, twin)]
    return [chart for chart in (*found, _controls(model, frames)) if chart.lines]


def touch_forces(
    model: mujoco.MjModel, frames: Frames, twin: Frames | None = None
) -> dict[str, Array]:
    """(frames,) force of every touch sensor that felt any, its twin's included [N], by name."""
    touching = model.sensor_type == mujoco.mjtSensor.mjSENS_TOUCH.value
    names = {k: model.sensor(k).name or f"sensor {k}" for k in np.flatnonzero(touching)}
    felt = np.vstack([one.readings for one in (frames, twin) if one is not None])
    places = {n: k for k, n in names.items() if felt[:, model.sensor_adr[k]].any()}
    return {n: frames.readings[:, model.sensor_adr[k]] for n, k in places.items()}


def _forces(model: mujoco.MjModel, frames: Frames, twin: Frames | None) -> Chart:
    forces = list(touch_forces(model, frames, twin).items())[:_MOST]
    several = len(forces) > 1
    lines = [
        Line(name.replace("_", " "), values, _OTHERS[k] if several else BLACK)
        for k, (name, values) in enumerate(forces)
    ]
    other = touch_forces(model, twin, frames) if twin else {}
    behind = [Line("", other[name], GREY, "--") for name, _ in forces if name in other]
    label = "force [N]" if several or not lines else f"{lines[0].name} [N]"
    return Chart(label, tuple(lines), tuple(behind))


def _tensions(model: mujoco.MjModel, frames: Frames) -> Chart:
    lines, colours = [], tendon_colours(model)
    ends: tuple[tuple[str, int, Style, str], ...] = (
        ("input", 0, "-", BLUE),
        ("output", -1, "--", VERMILLION),
    )
    several = len(frames.cables) > 1
    for name, cable in frames.cables.items():
        tendon = sheaths(model)[name].tendon
        for end, k, style, alone in ends:
            colour = colours[name] if several else alone
            entry = tendon if several and end == "input" else "" if several else f"{end} end"
            lines.append(Line(entry, cable.tensions[:, k], colour, style))
    return Chart("tension [N]", tuple(lines))


def _joints(model: mujoco.MjModel, frames: Frames, twin: Frames | None) -> Chart:
    """Hinges, or slides where there are none, that no actuator moves directly."""
    driven = model.actuator_trnid[model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT.value, 0]
    for kind, label, factor in (
        (mujoco.mjtJoint.mjJNT_HINGE, "joint angle [deg]", 180.0 / np.pi),
        (mujoco.mjtJoint.mjJNT_SLIDE, "displacement [mm]", 1e3),
    ):
        chosen = [k for k in range(model.njnt) if model.jnt_type[k] == kind.value]
        places = [model.jnt_qposadr[k] for k in chosen if k not in driven][:_MOST]
        names = [model.joint(k).name or f"joint {k}" for k in chosen if k not in driven]
        if places:
            lines = [
                Line(name, factor * frames.poses[:, place], colour)
                for name, place, colour in zip(names, places, _OTHERS, strict=False)
            ]
            behind = [Line("", factor * twin.poses[:, p], GREY, "--") for p in places if twin]
            return Chart(label, tuple(lines), tuple(behind))
    return Chart("", ())


def _controls(model: mujoco.MjModel, frames: Frames) -> Chart:
    moving = [k for k in range(model.nu) if np.ptp(frames.controls[:, k]) > 0.0][:_MOST]
    units = {control_unit(model, k) for k in moving}
    shared = f" [{units.pop()}]" if len(units) == 1 else ""
    lines = []
    for colour, k in zip(_OTHERS, moving, strict=False):
        name = model.actuator(k).name or f"actuator {k}"
        unit = "" if shared else f" [{control_unit(model, k)}]"
        lines.append(Line(name + unit, frames.controls[:, k], _tendon_of(model, name) or colour))
    return Chart(f"control{shared}", tuple(lines))


def _tendon_of(model: mujoco.MjModel, actuator: str) -> str:
    """Colour of the tendon whose name an actuator's begins with; empty if there is none."""
    for name, colour in tendon_colours(model).items():
        if actuator.startswith(sheaths(model)[name].tendon):
            return colour
    return ""


def control_unit(model: mujoco.MjModel, actuator: int) -> str:
    """Unit of an actuator's control; 1 where its kind does not say.

    Args:
        model: compiled.
        actuator: its number.
    """
    if model.actuator_plugin[actuator] >= 0:
        return "m"
    kind = model.actuator_trntype[actuator]
    turning = False
    if kind == mujoco.mjtTrn.mjTRN_JOINT.value:
        joint = model.actuator_trnid[actuator, 0]
        turning = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE.value
    elif kind != mujoco.mjtTrn.mjTRN_TENDON.value:
        return "1"
    if model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_MUSCLE.value:
        return "1"
    position, velocity = model.actuator_biasprm[actuator, 1:3]
    if model.actuator_biastype[actuator] != mujoco.mjtBias.mjBIAS_AFFINE.value:
        return "N m" if turning else "N"
    if position:
        return "rad" if turning else "m"
    if velocity:
        return "rad/s" if turning else "m/s"
    return "1"
