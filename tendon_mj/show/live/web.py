"""A page that shows a simulation in a browser, with sliders for its live parameters."""

from __future__ import annotations

import importlib
import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, MissingPackageError, TendonError
from tendon_mj.plugin import MARK, SLIPPING, THICKER
from tendon_mj.show.live.scene import (
    FIRST,
    MOST_TENDONS,
    Viewpoint,
    colour_bar,
    control_slider,
    curve_colours,
    curves_title,
    drawn_tendons,
    reading_table,
    slider,
    tension_table,
)
from tendon_mj.show.live.session import LiveSimulation, Prepared, RealTime, run_in_real_time
from tendon_mj.show.render.offscreen import GREY, without_tendons
from tendon_mj.show.render.see_through import colour_of
from tendon_mj.show.render.surroundings import FLOOR_COLOUR, Floor, floor, to_show
from tendon_mj.typing import FloatArray

HOST = "localhost"  # no other machine's browser: the page is not protected
_LAST_PORT = 65535
_FLOOR, _THIN = 3.0, 1e-3  # half a plane's width and height over the model's extent
_SCENE_EVERY, _RARELY = 4, 8  # frames of the simulation between new scenes, and between new curves
_POINT_SPACING = 0.5  # distance of two points over the radius that is drawn
_MOST_DOTS, _MOST_GEOMS = 8000, 20000  # of all tendons together
_HEIGHT, _WIDTH = 230, 380  # of the curves, and of the panels [pixels]
_CORNER, _BUTTONS = 15, 240  # place and width of the buttons on a wide screen [pixels]
_SHOWN_GROUPS = 3  # of geoms
_PER_CURVE = 400  # of a curve
_MOST_CONTROLS = 12  # whose sliders follow a motion
_LINEAR = 2.2  # exponent from a colour to the one that a batch of meshes takes
_EACH = "all sheaths"
_BY_HAND = "by hand, with the sliders"


def serve(
    prepared: Prepared,
    *,
    port: int = 8080,
    seconds: float | None = None,
    announce: Callable[[str], object] = print,
) -> RealTime:
    """Serve a simulation to browsers on this machine until Ctrl-C, or for some seconds.

    If the port is taken, it is the next one that is free; ``announce`` gets the address.
    """
    try:
        mjviser, viser = importlib.import_module("mjviser"), importlib.import_module("viser")
    except ImportError as error:
        raise MissingPackageError(
            f"`--web` needs mjviser ({error}); install it with pip install 'tendon-mj[web]'"
        ) from error
    if not 0 <= port <= _LAST_PORT:
        raise InvalidValueError(f"--port {port}: ports go from 0, any free one, to {_LAST_PORT}")
    with redirect_stdout(io.StringIO()):  # it announces itself at length
        server = viser.ViserServer(host=HOST, port=port, label="tendon_mj", verbose=False)
    try:
        simulation, frames = prepared.simulation, 0
        drawn = simulation.model
        shown = _drawable(drawn)
        translucent = _translucent(server.scene, mjviser, shown)
        scene = mjviser.ViserMujocoScene(server, shown, num_envs=1)
        scene.camera_tracking_enabled = False
        _add_floor(server.scene, floor(drawn, prepared.poses))
        server.on_client_connect(lambda client: _look(client.camera, prepared.view))
        cable, ghost = _Cable(server, simulation), _ghost(server.scene, mjviser, drawn)
        panel = _Panel(server.gui, viser.uplot, prepared)

        def show() -> bool:
            nonlocal frames, drawn, translucent
            if drawn is not simulation.model:  # in another motion, which needs other colours
                drawn = simulation.model
                translucent.remove()
                scene.mj_model = _drawable(drawn)
                translucent = _translucent(server.scene, mjviser, scene.mj_model)
                scene.rebuild_visual_handles()
            if frames % _SCENE_EVERY == 0:
                with server.atomic():  # in one message, which a browser shows in one frame
                    with simulation.lock:
                        scene.update_from_mjdata(simulation.data)
                        translucent.draw(simulation.data)
                        ghost.draw(simulation.twin)
                    cable.draw()
            if frames % _RARELY == 0:
                panel.draw()
            frames += 1
            return True

        announce(f"http://{HOST}:{server.get_port()} shows the model; Ctrl-C ends it")
        return run_in_real_time(simulation, show, seconds)
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


def _drawable(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy for mjviser.

    Planes become flat boxes: it would draw them without end, and as a veil before all the rest.
    Invisible sites and those on tendons go to a group that is not shown: it would draw them grey.
    """
    drawn = without_tendons(to_show(model))
    drawn.site_group[drawn.site_rgba[:, 3] == 0.0] = mujoco.mjNGROUP - 1
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE):
        width, depth = (size or _FLOOR * model.stat.extent for size in model.geom_size[geom, :2])
        drawn.geom_type[geom] = mujoco.mjtGeom.mjGEOM_BOX
        drawn.geom_size[geom] = width, depth, _THIN * model.stat.extent
    return drawn


def _add_floor(scene: Any, ground: Floor | None) -> None:
    """Show a floor."""
    if ground is not None:
        width, thin = 2.0 * ground.half_width, _THIN * ground.half_width
        colour = tuple(round(255.0 * part) for part in FLOOR_COLOUR)
        place = ground.middle - (0.0, 0.0, thin)
        scene.add_box(
            "/floor", colour, (width, width, 2.0 * thin), position=place, cast_shadow=False
        )


def _look(camera: Any, view: Viewpoint) -> None:
    view = view.seen_at(camera.aspect)
    camera.up_direction = (0.0, 0.0, 1.0)
    camera.position, camera.look_at = tuple(view.position), tuple(view.look_at)
    camera.fov, camera.near = float(np.radians(view.fovy)), 1e-3


class _Cable:
    """Tendons in the colours of their tension, and marks where they slip.

    They are rows of points: only these have exactly their colour in a browser, while lines and
    meshes go through the tone mapping of its renderer.
    """

    def __init__(self, server: Any, simulation: LiveSimulation) -> None:
        self._simulation = simulation
        self._scene = mujoco.MjvScene(simulation.model, _MOST_GEOMS)
        shown = to_show(simulation.model).tendon_width.max(initial=1e-6)
        width = THICKER * float(shown)
        self._spacing = _POINT_SPACING * width
        self._spans, self._marks = (
            server.scene.add_point_cloud(
                name,
                np.zeros((1, 3), np.float32),
                np.zeros((1, 3), np.uint8),
                point_size=size * width,
                point_shape="circle",
                point_shading="flat",
                precision="float32",
                visible=False,
            )
            for name, size in (("/tendons", 1.0), ("/slipping", MARK))
        )

    def draw(self) -> None:
        """Draw the tendons as they are now."""
        with self._simulation.lock:
            simulation = self._simulation
            ends, colours, slipping = drawn_tendons(simulation.model, simulation.data, self._scene)
        marks = np.tile(np.round(255.0 * np.array(SLIPPING)).astype(np.uint8), (len(slipping), 1))
        for handle, points, shown in (
            (self._spans, *row_of_points(ends, colours, self._spacing)),
            (self._marks, slipping, marks),
        ):
            handle.visible = len(points) > 0
            if handle.visible:
                handle.points, handle.colors = points.astype(np.float32), shown


class _Meshes:
    """Geoms that are drawn here, each set of them on its body and in one colour.

    Each is a batch of one mesh, as mjviser's bodies are: a browser shows a mesh's own pose one
    frame before points, and the pose in a batch with them.
    """

    def __init__(self, scene: Any, mjviser: Any, model: mujoco.MjModel, name: str) -> None:
        self._scene, self._merge, self._model = scene, mjviser.conversions.merge_geoms, model
        self._name, self._handles = name, list[tuple[int, Any]]()

    def add(self, geoms: Sequence[int], colour: Sequence[float], opacity: float) -> None:
        """Add geoms of one body, in red, green and blue from 0 to 1."""
        mesh = self._merge(self._model, list(geoms))
        handle = self._scene.add_batched_meshes_simple(
            f"/{self._name}/{geoms[0]}",
            np.array(mesh.vertices),
            np.array(mesh.faces),
            batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
            batched_positions=np.zeros((1, 3)),
            batched_colors=tuple(round(255.0 * part**_LINEAR) for part in colour),
            opacity=opacity,
            visible=False,
        )
        self._handles.append((int(self._model.geom_bodyid[geoms[0]]), handle))

    def draw(self, data: mujoco.MjData | None) -> None:
        """Draw them where their bodies are, or not at all."""
        for body, handle in self._handles:
            handle.visible = data is not None
            if data is not None:
                handle.batched_positions = data.xpos[[body]]
                handle.batched_wxyzs = data.xquat[[body]]

    def remove(self) -> None:
        """Take them out of the scene."""
        for _, handle in self._handles:
            handle.remove()


def _ghost(scene: Any, mjviser: Any, model: mujoco.MjModel) -> _Meshes:
    """Moving bodies in grey, for a twin without friction."""
    shown = (model.body_weldid[model.geom_bodyid] != 0) & (model.geom_rgba[:, 3] > 0.0)
    shown &= model.geom_group < _SHOWN_GROUPS
    ghost = _Meshes(scene, mjviser, model, "ghost")
    for body in np.unique(model.geom_bodyid[shown]):
        ghost.add(np.flatnonzero(shown & (model.geom_bodyid == body)).tolist(), GREY, 0.5)
    return ghost


def _translucent(scene: Any, mjviser: Any, drawn: mujoco.MjModel) -> _Meshes:
    """Translucent geoms, taken out of the model, which mjviser would draw opaque."""
    glass = _Meshes(scene, mjviser, drawn, "translucent")
    for geom in np.flatnonzero(drawn.geom_group < _SHOWN_GROUPS).tolist():
        *colour, opacity = colour_of(drawn, geom)
        if 0.0 < opacity < 1.0:
            glass.add([geom], colour, opacity)
            drawn.geom_group[geom] = mujoco.mjNGROUP - 1
    return glass


def row_of_points(
    ends: FloatArray, colours: NDArray[np.uint8], spacing: float, most: int = _MOST_DOTS
) -> tuple[FloatArray, NDArray[np.uint8]]:
    """(k, 3) points [m] along all spans, including their ends, and (k, 3) colours.

    Their spacing is at most ``spacing`` [m], unless that takes more than ``most`` points.
    """
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    if not lengths.size:
        return np.zeros((0, 3)), np.zeros((0, 3), np.uint8)
    spacing = max(spacing, float(lengths.sum()) / max(1, most - 2 * len(lengths)))
    counts = np.ceil(lengths / spacing).astype(int) + 1
    span = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(span)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (place / np.maximum(1, counts - 1)[span])[:, None]
    points = (1.0 - share) * ends[span, 0] + share * ends[span, 1]
    return points, colours[span]


class _Panel:
    """Buttons, numbers, curves and sliders next to the scene; on a phone folded below it."""

    def __init__(self, gui: Any, uplot: Any, prepared: Prepared) -> None:
        self._gui, self._simulation, self._prepared = gui, prepared.simulation, prepared
        simulation = self._simulation
        self._tendons, self._unit = list(simulation.tendons.values()), prepared.force_unit
        self._handles: dict[str, tuple[Any, float]] = {}  # of sliders, and their units over SI
        self._controls: list[tuple[Any, float]] = []  # the same of actuators
        self._add_buttons()
        self._problem = gui.add_markdown("", visible=False)
        panel = gui.add_panel()
        with panel.add_tab("tensions, motion"):
            if prepared.low < prepared.high:
                limits = prepared.low, prepared.high
                gui.add_html(colour_bar(limits, simulation.can_slip, self._unit))
            self._curves = self._add_curves(uplot) if self._tendons else None
            tabs = gui.add_tab_group()
            with tabs.add_tab("motion"):
                self._add_motions()
            if self._tendons:
                with tabs.add_tab("friction"):
                    self._add_sliders()
            with tabs.add_tab("numbers"):
                self._table = gui.add_markdown("")
        gui.main_panel.float(x=-_CORNER, y=_CORNER, width=_BUTTONS)
        panel.dock_right()
        panel.set_width(_WIDTH)
        self.draw()

    def draw(self) -> None:
        """Show the readings as they are now."""
        simulation = self._simulation
        times, tensions = simulation.curves()
        if not simulation.is_by_hand and len(self._controls) <= _MOST_CONTROLS:
            self._show_controls()
        with simulation.lock:
            readings = reading_table(simulation.model, simulation.data, self._unit)
        now = tension_table(self._tendons, tensions[-1], float(times[-1]), self._unit)
        self._table.content = f"{now}\n\n{readings}"
        if self._curves is None:
            return
        chosen = np.unique(np.linspace(0, len(times) - 1, min(len(times), _PER_CURVE)).astype(int))
        kept = self._unit.factor * tensions[chosen, :MOST_TENDONS]
        rows = np.nan_to_num(kept.reshape(len(chosen), -1), posinf=0.0)
        self._curves.data = (times[chosen], *(np.ascontiguousarray(row) for row in rows.T))

    def _add_curves(self, uplot: Any) -> Any:
        colours = (
            255.0 * curve_colours(self._simulation.model, [*self._simulation.tendons])
        ).astype(int)
        series = [uplot.Series(label="time [s]")]
        for name, ends in list(zip(self._tendons, colours, strict=True))[:MOST_TENDONS]:
            for end, (red, green, blue) in zip(("input", "output"), ends, strict=True):
                stroke = f"rgb({red},{green},{blue})"
                series.append(uplot.Series(label=f"{name} {end}", stroke=stroke, width=2))
        return self._gui.add_uplot(
            tuple(np.zeros(1) for _ in series),
            tuple(series),
            title=curves_title(len(self._tendons), self._unit),
            scales={"x": uplot.Scale(time=False)},
            legend=uplot.Legend(show=True, live=False),
            height=_HEIGHT,
            padding=(12, 24, 0, 0),  # of which the first is for the uppermost number
        )

    def _add_buttons(self) -> None:
        simulation = self._simulation
        pause, restart = self._gui.add_button("pause"), self._gui.add_button("restart")

        @pause.on_click
        def _(event: Any) -> None:
            simulation.paused = not simulation.paused
            pause.label = "resume" if simulation.paused else "pause"

        @restart.on_click
        def _(event: Any) -> None:
            simulation.reset()
            self.draw()

    def _add_motions(self) -> None:
        """List of motions, twin on and off, and a slider for each actuator."""
        simulation, motions, gui = self._simulation, self._prepared.motions, self._gui
        if simulation.can_slip:
            twin = gui.add_checkbox("compare without friction", False, hint="a grey ghost")
            twin.on_update(lambda event: simulation.compare(twin.value))
        if simulation.step is not None or simulation.model.nu == 0:
            return
        chosen = gui.add_dropdown("motion", (*motions, _BY_HAND)) if motions else None
        for k, control in enumerate(simulation.data.ctrl):
            shown = control_slider(simulation.model, k, float(control), self._unit)
            handle = gui.add_slider(*shown[:1], *shown[2:6], hint=shown.hint)
            self._controls.append((handle, shown.factor))

            @handle.on_update
            def _(event: Any, actuator: int = k, factor: float = shown.factor) -> None:
                if event.client is None:  # set by the program
                    return
                # first of all, lest the motion set the slider again
                simulation.hold(actuator, float(event.target.value) / factor)
                if chosen is not None and chosen.value != _BY_HAND:
                    chosen.value = _BY_HAND
                    self._show_controls(actuator)

        if chosen is not None:

            @chosen.on_update
            def _(event: Any) -> None:
                if chosen.value != _BY_HAND:
                    simulation.play(*motions[chosen.value]())
                elif event.client is not None:
                    simulation.hold(0, float(simulation.data.ctrl[0]))
                    self._show_controls()

    def _show_controls(self, but: int = -1) -> None:
        """Put the sliders of the actuators, but for one, where their controls are."""
        for k, (handle, factor) in enumerate(self._controls):
            now = float(np.clip(factor * self._simulation.data.ctrl[k], handle.min, handle.max))
            if k != but and abs(now - handle.value) > 0.5 * handle.step:
                wide = float(f"{now:.3g}")  # as its box
                handle.value = round(wide, handle.precision) + 0.0  # never −0

    def _add_sliders(self) -> None:
        simulation, names = self._simulation, tuple(self._simulation.tendons)
        chosen = None
        if len(names) > 1:
            chosen = self._gui.add_dropdown("sheath", (_EACH, *names), initial_value=_EACH)

        def sheaths() -> Sequence[str]:
            return names if chosen is None or chosen.value == _EACH else [chosen.value]

        for parameter in FIRST:
            self._add_slider(parameter, sheaths)
        with self._gui.add_folder("further effects", expand_by_default=False):
            for sheath, _, parameter in (key.rpartition(".") for key in simulation.parameters):
                if sheath == names[0] and parameter not in self._handles:
                    self._add_slider(parameter, sheaths)
        if chosen is not None:

            @chosen.on_update
            def _(event: Any) -> None:
                for parameter, (handle, factor) in self._handles.items():
                    handle.value = factor * simulation.parameters[f"{sheaths()[0]}.{parameter}"]

    def _add_slider(self, parameter: str, sheaths: Callable[[], Sequence[str]]) -> None:
        simulation, name = self._simulation, f"{sheaths()[0]}.{parameter}"
        shown = slider(parameter, simulation.parameters.get(name, 0.0))
        if shown is None or name not in simulation.parameters:  # of no use to the sheath
            return
        handle = self._gui.add_slider(
            shown.label, shown.low, shown.high, shown.step, shown.value, hint=shown.hint
        )

        @handle.on_update
        def _(event: Any) -> None:
            if event.client is None:  # set by the choice of a sheath
                return
            try:
                for sheath in sheaths():
                    simulation.set(f"{sheath}.{parameter}", float(handle.value) / shown.factor)
                self._problem.visible = False
            except TendonError as error:
                self._problem.content, self._problem.visible = f"**{error}**", True

        self._handles[parameter] = handle, shown.factor
