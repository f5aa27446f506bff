"""Charts of a clip: forces, tensions, joint angles and controls over time."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from typing import Literal, NamedTuple

import mujoco
import numpy as np
from matplotlib.colors import to_hex

from tendon_mj.lab.replay import EngineeringUnit, Frames, control_unit, engineering_unit
from tendon_mj.plugin import sheaths
from tendon_mj.show.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION
from tendon_mj.typing import FloatArray

Style = Literal["-", "--", "-.", ":"]
# for tendons with the same colour in the model; the last two are of Paul Tol's palette
TENDONS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, "#332288", "#882255")
_OTHERS = (GREEN, PURPLE, ORANGE, SKY)  # of joints, apart from the colours of two tendons
_ENDS: tuple[tuple[Style, Style], ...] = (("-", "--"), ("-.", ":"))  # input and output end
_MOST = 4  # lines of one kind in a chart
_MOST_TENDONS = len(TENDONS) * len(_ENDS)
_UNCOLOURED = (0.5, 0.5, 0.5)  # MuJoCo's default colour of a tendon


class Line(NamedTuple):
    """A line of a chart, (frames,) values; no name where another one's entry stands for it."""

    name: str
    values: FloatArray
    colour: str
    style: Style = "-"


class Chart(NamedTuple):
    """Lines over time with one axis, and grey ones of the frictionless twin behind them."""

    label: str
    lines: Sequence[Line]
    twin: Sequence[Line] = ()
    left_out: int = 0


def tendon_colours(model: mujoco.MjModel) -> dict[str, str]:
    """Colour of the tendon of every sheath: the model's if no other has it, else the next."""
    drawn = {
        name: to_hex(model.tendon_rgba[model.tendon(sheath.tendon).id, :3])
        for name, sheath in sheaths(model).items()
    }
    given = Counter(drawn.values())
    kept = {c for c, times in given.items() if times == 1 and c != to_hex(_UNCOLOURED)}
    free = itertools.cycle([c for c in TENDONS if c.lower() not in kept])
    return {name: colour if colour in kept else next(free) for name, colour in drawn.items()}


def charts(model: mujoco.MjModel, frames: Frames, twin: Frames | None = None) -> list[Chart]:
    """Charts of the quantities that there are, the most important first."""
    drawn = (
        _forces(model, frames, twin),
        _tensions(model, frames),
        _joints(model, frames, twin),
        _controls(model, frames),
    )
    return [chart for chart in drawn if chart.lines]


def touch_forces(
    model: mujoco.MjModel, frames: Frames, twin: Frames | None = None
) -> dict[str, FloatArray]:
    """(frames,) force of every touch sensor that felt any, here or in the twin [N], by name."""
    touching = model.sensor_type == mujoco.mjtSensor.mjSENS_TOUCH.value
    names = {k: model.sensor(k).name or f"sensor {k}" for k in np.flatnonzero(touching)}
    felt = np.vstack([f.readings for f in (frames, twin) if f is not None])
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
    return Chart("force [N]" if several or not lines else f"{lines[0].name} [N]", lines, behind)


def _tensions(model: mujoco.MjModel, frames: Frames) -> Chart:
    if len(frames.cables) == 1:
        ((_, cable),) = frames.cables.items()
        first = Line("input end", cable.tensions[:, 0], BLUE, _ENDS[0][0])
        last = Line("output end", cable.tensions[:, -1], VERMILLION, _ENDS[0][1])
        return Chart("tension [N]", [first, last])
    lines, colours, used = [], tendon_colours(model), Counter[str]()
    for name, cable in list(frames.cables.items())[:_MOST_TENDONS]:
        colour = colours[name]
        styles = _ENDS[used[colour] % len(_ENDS)]
        used[colour] += 1
        lines.append(Line(sheaths(model)[name].tendon, cable.tensions[:, 0], colour, styles[0]))
        lines.append(Line("", cable.tensions[:, -1], colour, styles[1]))
    return Chart("tension [N]", lines, left_out=len(frames.cables) - len(lines) // 2)


def _joints(model: mujoco.MjModel, frames: Frames, twin: Frames | None) -> Chart:
    """Hinges, or slides where there are none, that no actuator moves directly."""
    driven = model.actuator_trnid[model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT.value, 0]
    for kind, label, si in (
        (mujoco.mjtJoint.mjJNT_HINGE, "joint angle", "rad"),
        (mujoco.mjtJoint.mjJNT_SLIDE, "displacement", "m"),
    ):
        chosen = [k for k in np.flatnonzero(model.jnt_type == kind.value) if k not in driven]
        places = [model.jnt_qposadr[k] for k in chosen[:_MOST]]
        if places:
            unit = engineering_unit(si, frames.poses[:, places].ravel())
            lines = [
                Line(model.joint(k).name or f"joint {k}", unit.factor * frames.poses[:, p], colour)
                for k, p, colour in zip(chosen, places, _OTHERS, strict=False)
            ]
            behind = [Line("", unit.factor * twin.poses[:, p], GREY, "--") for p in places if twin]
            return Chart(_labelled(label, unit), lines, behind, len(chosen) - len(places))
    return Chart("", [])


def _controls(model: mujoco.MjModel, frames: Frames) -> Chart:
    moving = [k for k in range(model.nu) if np.ptp(frames.controls[:, k]) > 0.0]
    shown = moving[:_MOST]
    alike: dict[str, list[int]] = {}  # SI unit → controls in it
    for k in shown:
        alike.setdefault(control_unit(model, k), []).append(k)
    units = {si: engineering_unit(si, frames.controls[:, ks].ravel()) for si, ks in alike.items()}
    lines, tendons, known = [], tendon_colours(model), sheaths(model)
    for colour, k in zip(_OTHERS, shown, strict=False):
        name, unit = model.actuator(k).name or f"actuator {k}", units[control_unit(model, k)]
        values = unit.factor * frames.controls[:, k]
        of_tendon = (c for sheath, c in tendons.items() if name.startswith(known[sheath].tendon))
        entry = name if len(units) == 1 else _labelled(name, unit)
        lines.append(Line(entry, values, next(of_tendon, colour)))
    label = _labelled("control", *(units.values() if len(units) == 1 else ()))
    return Chart(label, lines, left_out=len(moving) - len(shown))


def _labelled(name: str, unit: EngineeringUnit | None = None) -> str:
    """A name with its unit, if it has one."""
    return f"{name} [{unit.symbol}]" if unit and unit.symbol else name
