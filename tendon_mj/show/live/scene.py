"""What window and page show of a model: its view, tendons, tensions, key of colours and sliders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from tendon_mj.lab.motion import control_limits
from tendon_mj.lab.replay import control_unit
from tendon_mj.lab.units import NEWTON, EngineeringUnit, engineering_unit
from tendon_mj.plugin import PARAMETERS, SLIPPING
from tendon_mj.show.render.offscreen import COLOURS
from tendon_mj.show.render.panel import tendon_colours
from tendon_mj.show.render.surroundings import first_camera, framing
from tendon_mj.show.style import labelled
from tendon_mj.typing import FloatArray

_PALER = 0.5  # share of white in the curve of the output
_TENDON, _DYNAMIC = mujoco.mjtObj.mjOBJ_TENDON.value, mujoco.mjtCatBit.mjCAT_DYNAMIC.value
_SPAN_GEOM, _MARK_GEOM = mujoco.mjtGeom.mjGEOM_CAPSULE.value, mujoco.mjtGeom.mjGEOM_SPHERE.value
MOST_TENDONS = 6  # tendons that have curves
MOST_JOINTS = 12  # of a kind whose positions are numbers
_ASPECT = 1.15  # width over height of the narrowest window that needs no step back
_RAISED = 0.22  # over the height of a narrower one
_INCH = 100
_FONT = 8  # [points]
_NO_BREAK = "\N{NO-BREAK SPACE}"
_NAME_COLUMNS = 2  # of names: input and output of a tendon
# changed most, in the order in which they are shown; the others are folded away
FIRST = ("friction", "pretension", "backlash", "axial_stiffness")
_SLIDER_STEPS = 200
_SLIDER_WIDER = 3.0  # upper end of a slider over the model's value
# upper ends where the model's value is 0, of the order that real transmissions have
_TYPICAL = {
    "friction": 0.6,
    "static_friction": 0.6,
    "constant_friction": 5.0,
    "axial_stiffness": 20e3,
    "axial_damping": 100.0,
    "pretension": 40.0,
    "stribeck_friction": 0.3,
    "stribeck_velocity": 0.05,
    "viscous_friction": 100.0,
    "direction_asymmetry": 0.5,
    "friction_gradient": 1.0,
    "load_gradient": 0.01,
    "friction_drift": 0.1,
    "backlash": 0.005,
    "stiffening": 50.0,
    "creep": 0.5,
    "creep_time": 10.0,
    "sheath_compliance": 1e-4,
    "output_compliance": 1e-4,
    "tendon_mass": 0.05,
    "extra_bend": math.pi,
    "slack": 0.01,
}


class Viewpoint(NamedTuple):
    """An upright view from a position to a point [m], around which it turns; its height [deg]."""

    position: FloatArray
    look_at: FloatArray
    fovy: float

    def seen_at(self, aspect: float) -> Viewpoint:
        """The view for a window of ``aspect`` width over height, from farther away if it is narrow.

        What is looked at is then in its upper half: it is a phone's, with a panel below.
        """
        farther = max(1.0, _ASPECT / aspect)
        away = farther * (self.position - self.look_at)
        height = 2.0 * np.tan(0.5 * np.radians(self.fovy)) * np.linalg.norm(away)
        lower = np.array([0.0, 0.0, _RAISED * height if farther > 1.0 else 0.0])
        return self._replace(position=self.look_at + away - lower, look_at=self.look_at - lower)


def first_view(model: mujoco.MjModel, poses: FloatArray | None = None) -> Viewpoint:
    """The view of the first camera that shows the tendons, or one that frames them.

    It does in (k, nq) ``poses``, by default in `qpos0`.
    """
    first = first_camera(model, poses)
    if first < 0:
        camera = framing(model, poses)
        turned, raised = np.radians([camera.azimuth, camera.elevation])
        flat = np.cos(raised)
        forward = np.array([flat * np.cos(turned), flat * np.sin(turned), np.sin(raised)])
        look_at = np.array(camera.lookat)
        return Viewpoint(
            look_at - camera.distance * forward, look_at, float(model.vis.global_.fovy)
        )
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    position, forward = data.cam_xpos[first].copy(), -data.cam_xmat[first].reshape(3, 3)[:, 2]
    ahead = float((model.stat.center - position) @ forward)
    distance = ahead if ahead > 0.0 else float(model.stat.extent)
    return Viewpoint(position, position + distance * forward, float(model.cam_fovy[first]))


def look_from(camera: mujoco.MjvCamera, model: mujoco.MjModel, view: Viewpoint) -> None:
    """Give a view to a camera that the mouse turns; the field of view is the model's."""
    x, y, z = view.look_at - view.position
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = view.look_at
    camera.distance = float(np.linalg.norm([x, y, z]))
    camera.azimuth = float(np.degrees(np.arctan2(y, x)))
    camera.elevation = float(np.degrees(np.arctan2(z, np.hypot(x, y))))
    model.vis.global_.fovy = view.fovy


def curve_colours(model: mujoco.MjModel, names: Sequence[str]) -> FloatArray:
    """(sheaths, 2, 3) red, green and blue of the curves of input and output, 0 to 1."""
    colours = tendon_colours(model, names)
    full = np.array([to_rgb(colours[name]) for name in names]).reshape(-1, 3)
    return np.stack([full, (1.0 - _PALER) * full + _PALER], axis=1)


def drawn_tendons(
    model: mujoco.MjModel, data: mujoco.MjData, scene: mujoco.MjvScene
) -> tuple[FloatArray, NDArray[np.uint8], FloatArray]:
    """Tendons as MuJoCo and the plugin draw them, for a viewer that has its own primitives.

    The data were evaluated; the scene changes. Without a tension scale a tendon has its own colour.
    Returns (n, 2, 3) ends of the spans [m], their (n, 3) colours, 0 to 255, and (k, 3) guides over
    which a tendon slips [m].
    """
    option = mujoco.MjvOption()
    option.flags[:] = 0
    option.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = 1
    option.geomgroup[:] = option.sitegroup[:] = 0
    option.tendongroup[:] = 1
    mujoco.mjv_updateScene(model, data, option, None, mujoco.MjvCamera(), _DYNAMIC, scene)
    ends, colours, slipping = [], [], []
    drawn = [geom for geom in scene.geoms[: scene.ngeom] if geom.objtype == _TENDON]
    coloured = {geom.objid for geom in drawn if geom.emission > 1.0}  # by the plugin
    for geom in drawn:
        if geom.objid in coloured and geom.emission <= 1.0:
            continue
        if geom.type == _MARK_GEOM:
            slipping.append(geom.pos.copy())
        elif geom.type == _SPAN_GEOM:
            along = geom.size[2] * geom.mat[:, 2]
            ends.append([geom.pos - along, geom.pos + along])
            colours.append(max(geom.emission, 1.0) * geom.rgba[:3])
    return (
        np.array(ends, float).reshape(-1, 2, 3),
        np.round(255.0 * np.clip(np.array(colours).reshape(-1, 3), 0.0, 1.0)).astype(np.uint8),
        np.array(slipping, float).reshape(-1, 3),
    )


def tension_text(
    tendons: Sequence[str], tensions: FloatArray, time: float, unit: EngineeringUnit = NEWTON
) -> tuple[str, str]:
    """Two columns of text: labels, and values in a unit of the (tendons, 2) tensions [N]."""
    left, right = ["time [s]"], [f"{time:.1f}"]
    scaled = unit.factor * tensions
    for name, (first, last) in list(zip(tendons, scaled, strict=True))[:MOST_TENDONS]:
        left.append(labelled(f"{name}: input to output tension", unit))
        right.append(f"{first:.1f} to {last:.1f}")
    if len(tendons) > MOST_TENDONS:
        left.append(f"and {len(tendons) - MOST_TENDONS} more tendons")
        right.append("")
    return "\n".join(left), "\n".join(right)


def tension_table(
    tendons: Sequence[str], tensions: FloatArray, time: float, unit: EngineeringUnit = NEWTON
) -> str:
    """Tensions as a table in Markdown; see `tension_text`."""
    ends = (labelled(end, unit) for end in ("input", "output"))
    rows = [f"| tendon | {' | '.join(ends)} |", "|---|---|---|"]
    for name, (first, last) in zip(tendons, unit.factor * tensions, strict=True):
        rows.append(f"| {name} | {first:.2f} | {last:.2f} |")
    return "\n".join([*rows, "", f"time {time:.1f} s"])


def curves_title(tendons: int, unit: EngineeringUnit = NEWTON) -> str:
    """Title of a page's curves, which names the number of tendons if some have none."""
    title = f"{labelled('tension', unit)} over time [s]"
    if tendons <= MOST_TENDONS:
        return title
    kept = f"{MOST_TENDONS} of {tendons} tendons"
    # on a phone in a line of its own, apart from the button beside the first
    return f"{title}, {kept.replace(' ', _NO_BREAK)}"


def reading_table(
    model: mujoco.MjModel, data: mujoco.MjData, unit: EngineeringUnit = NEWTON
) -> str:
    """Forces of touch sensors and positions of joints as a table in Markdown; empty without any."""
    rows = []
    for k in np.flatnonzero(model.sensor_type == mujoco.mjtSensor.mjSENS_TOUCH.value):
        name = (model.sensor(k).name or f"sensor {k}").replace("_", " ")
        force = unit.factor * data.sensordata[model.sensor_adr[k]]
        rows.append(f"| {labelled(name, unit)} | {force:.2f} |")
    for kind, symbol, factor in (
        (mujoco.mjtJoint.mjJNT_HINGE, "°", math.degrees(1.0)),
        (mujoco.mjtJoint.mjJNT_SLIDE, "mm", 1e3),
    ):
        for k in np.flatnonzero(model.jnt_type == kind.value)[:MOST_JOINTS]:
            name, place = model.joint(k).name or f"joint {k}", data.qpos[model.jnt_qposadr[k]]
            now = f"{factor * place:z.1f}".replace("-", "−")
            rows.append(f"| {name} [{symbol}] | {now} |")
    return "\n".join(["| sensor or joint | now |", "|---|---|", *rows]) if rows else ""


def colour_bar(limits: tuple[float, float], slips: bool, unit: EngineeringUnit = NEWTON) -> str:
    """The colours between two tensions [N] as HTML, in the text's colour of the page.

    With ``slips`` the mark of a guide over which a tendon slips is explained, too.
    """
    low, high = (unit.factor * limit for limit in limits)
    colours = ",".join(to_hex(colour) for colour in COLOURS(np.linspace(0.0, 1.0, 9)))
    ends = [f"≤ {low:g}", f"{0.5 * (low + high):g}", f"≥ {high:g}"]
    ticks = "".join(f"<span>{end} {unit.symbol}</span>" for end in ends)
    mark = f'<span style="color:{to_hex(SLIPPING)}">●</span> slips over this guide'
    return (
        '<div style="padding:0.2em 0.8em;font-size:0.85em">tension along the tendon'
        f'<div style="height:1em;background:linear-gradient(to right,{colours})"></div>'
        f'<div style="display:flex;justify-content:space-between">{ticks}</div>'
        f"{mark if slips else ''}</div>"
    )


def colour_key(
    limits: tuple[float, float],
    tendons: Sequence[str],
    colours: FloatArray,
    width: int,
    height: int,
    slips: bool = True,
    unit: EngineeringUnit = NEWTON,
) -> NDArray[np.uint8]:
    """(height, width, 3) picture of a horizontal colour bar, and lines with names.

    The bar ends at the tensions ``limits`` [N], and is left out where they are alike; the curves of
    the named tendons at input and output have (tendons, 2, 3) colours, 0 to 1; with ``slips`` marks
    of slipping guides are explained.
    """
    figure = Figure(figsize=(width / _INCH, height / _INCH), dpi=_INCH, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    if limits[0] < limits[1]:
        shown = Normalize(unit.factor * limits[0], unit.factor * limits[1])
        scale, place = ScalarMappable(shown, COLOURS), figure.add_subplot()
        bar = figure.colorbar(scale, cax=place, orientation="horizontal", extend="both")
        mark = ";\nmagenta: it slips over this guide" if slips else ""
        title = labelled("tension along the tendon", unit)
        bar.set_label(f"{title}, at the tips or beyond{mark}", size=_FONT)
        bar.ax.tick_params(labelsize=_FONT)
    lines = [
        Line2D([], [], color=colour, linewidth=2.5, label=f"{name} {end}")
        for name, both in zip(tendons, colours, strict=True)
        for colour, end in zip(both, ("input", "output"), strict=True)
    ]
    if lines:
        figure.legend(
            handles=lines,
            loc="outside lower center",
            ncols=_NAME_COLUMNS,
            fontsize=_FONT,
            frameon=False,
            handlelength=1.2,
            columnspacing=1.0,
        )
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3].copy()


def key_height(tendons: int, has_bar: bool = True) -> int:
    """Height that the picture of so many tendons' colours needs [pixels]."""
    return (92 if has_bar else 8) + 17 * -(-2 * tendons // _NAME_COLUMNS)


class Slider(NamedTuple):
    """A slider of one live parameter of a sheath, in the unit of its label: ``factor`` over SI."""

    label: str
    hint: str
    low: float
    high: float
    step: float
    value: float
    factor: float


def control_slider(
    model: mujoco.MjModel, actuator: int, value: float, forces: EngineeringUnit = NEWTON
) -> Slider:
    """The slider of an actuator that has this control [SI], a force in the unit of ``forces``."""
    low, high = (float(limit[actuator]) for limit in control_limits(model))
    si = control_unit(model, actuator)
    unit = forces if si == "N" else engineering_unit(si, [low, high])
    label = labelled(model.actuator(actuator).name or f"actuator {actuator}", unit)
    value = min(max(value, low), high)
    scaled = (unit.factor * x for x in (low, high, (high - low) / _SLIDER_STEPS, value))
    low, high, step, value = (float(f"{x:.3g}") for x in scaled)
    return Slider(label, "moves it by hand", low, high, step, value, unit.factor)


def slider(parameter: str, value: float) -> Slider | None:
    """The slider of a sheath's parameter that has this value [SI]; None for a radius."""
    if parameter not in _TYPICAL:
        return None
    known = PARAMETERS[parameter]
    high = _SLIDER_WIDER * abs(value)
    if value == 0.0 or parameter in ("friction", "static_friction"):
        high = max(high, _TYPICAL[parameter])
    step = high / _SLIDER_STEPS
    low = 0.0 if known.range.admits(0.0) else step
    if known.range.low < 0.0:
        low = max(-high, known.range.low + step)
    unit = engineering_unit(known.unit, [high])
    label = labelled(parameter.replace("_", " "), unit)
    low, high, step, value = (unit.factor * x for x in (low, high, step, value))
    return Slider(label, known.text, low, high, step, value, unit.factor)
