"""A page that shows a simulation in a browser, with sliders for its live parameters."""

from __future__ import annotations

import copy
import importlib
import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, MissingPackageError, TendonError
from tendon_mj.show.live.scene import (
    FIRST,
    MOST_TENDONS,
    Viewpoint,
    colour_key,
    curve_colours,
    drawn_tendons,
    key_height,
    slider,
    tension_table,
)
from tendon_mj.show.live.session import LiveSimulation, Prepared, RealTime, run_in_real_time
from tendon_mj.typing import FloatArray

HOST = "localhost"  # no other machine's browser: the page is not protected
_LAST_PORT = 65535
_FLOOR, _THIN = 3.0, 1e-3  # half a plane's width and height over the model's extent
_SCENE_EVERY, _RARELY = 4, 8  # frames of the simulation between new scenes, and between new curves
_THICKER = 2.5  # than MuJoCo's own tendon, which is hard to see in a browser
_MARK_SIZE = 5.0  # size of a slipping guide over the tendon's radius
_POINT_SPACING = 0.5  # distance of two points over the radius that is drawn
_MOST_DOTS, _MOST_GEOMS = 8000, 20000  # of all tendons together
_SLIPPING = (230, 0, 122)  # magenta, as the plugin draws it
_PX = 400  # of the key of colours [pixels]
_HEIGHT = 230  # of the curves [pixels]
_PER_CURVE = 400  # of a curve
_EACH = "all sheaths"
_RESTART = "restart the motion"  # the sliders stay as they are


def serve(
    prepared: Prepared,
    *,
    port: int = 8080,
    seconds: float | None = None,
    announce: Callable[[str], object] = print,
) -> RealTime:
    """Serve a simulation to browsers on this machine until Ctrl-C, or for some seconds.

    Where the port is taken, it is the next one that is free; ``announce`` gets the address.
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
        scene = mjviser.ViserMujocoScene(server, _drawable(simulation.model), num_envs=1)
        scene.camera_tracking_enabled = False
        server.gui.configure_theme(control_layout="fixed", control_width="large")
        server.on_client_connect(lambda client: _look(client.camera, prepared.view))
        cable, panel = _Cable(server, simulation), _Panel(server.gui, viser.uplot, prepared)

        def show() -> bool:
            nonlocal frames
            if frames % _SCENE_EVERY == 0:
                with simulation.lock:
                    scene.update_from_mjdata(simulation.data)
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
    Invisible sites go to a group that is not shown: it would draw them grey.
    """
    drawn = copy.copy(model)
    drawn.site_group[model.site_rgba[:, 3] == 0.0] = mujoco.mjNGROUP - 1
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE):
        width, depth = (size or _FLOOR * model.stat.extent for size in model.geom_size[geom, :2])
        drawn.geom_type[geom] = mujoco.mjtGeom.mjGEOM_BOX
        drawn.geom_size[geom] = width, depth, _THIN * model.stat.extent
    return drawn


def _look(camera: Any, view: Viewpoint) -> None:
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
        width = float(simulation.model.tendon_width.max(initial=1e-6))
        self._spacing = _POINT_SPACING * _THICKER * width
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
            for name, size in (("/tendons", _THICKER), ("/slipping", _MARK_SIZE))
        )

    def draw(self) -> None:
        """Draw the tendons as they are now."""
        with self._simulation.lock:
            simulation = self._simulation
            ends, colours, slipping = drawn_tendons(simulation.model, simulation.data, self._scene)
        marks = np.tile(np.array(_SLIPPING, np.uint8), (len(slipping), 1))
        for handle, points, shown in (
            (self._spans, *row_of_points(ends, colours, self._spacing)),
            (self._marks, slipping, marks),
        ):
            handle.visible = len(points) > 0
            if handle.visible:
                handle.points, handle.colors = points.astype(np.float32), shown


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
    """Numbers, curves, sliders and buttons beside the scene."""

    def __init__(self, gui: Any, uplot: Any, prepared: Prepared) -> None:
        self._gui, self._simulation = gui, prepared.simulation
        self._tendons = list(prepared.simulation.tendons.values())
        self._problem = gui.add_markdown("", visible=False)
        self._handles: dict[str, tuple[Any, float]] = {}  # of sliders, and their units over SI
        if self._tendons:
            limits, none = (prepared.low, prepared.high), np.zeros((0, 2, 3))
            key = colour_key(limits, [], none, _PX, key_height(0))  # the curves have their names
            gui.add_image(key, format="png")
            self._table = gui.add_markdown("")
            self._curves = self._add_curves(uplot)
            self._add_sliders()
            self.draw()
        self._add_buttons()

    def draw(self) -> None:
        """Show the tensions as they are now."""
        if not self._tendons:
            return
        times, tensions = self._simulation.curves()
        self._table.content = tension_table(self._tendons, tensions[-1], float(times[-1]))
        chosen = np.unique(np.linspace(0, len(times) - 1, min(len(times), _PER_CURVE)).astype(int))
        rows = np.nan_to_num(tensions[chosen, :MOST_TENDONS].reshape(len(chosen), -1), posinf=0.0)
        self._curves.data = (times[chosen], *(np.ascontiguousarray(row) for row in rows.T))

    def _add_curves(self, uplot: Any) -> Any:
        colours = (255.0 * curve_colours(self._simulation.model)).astype(int)
        series = [uplot.Series(label="time [s]")]
        for name, ends in list(zip(self._tendons, colours, strict=True))[:MOST_TENDONS]:
            for end, (red, green, blue) in zip(("input", "output"), ends, strict=True):
                stroke = f"rgb({red},{green},{blue})"
                series.append(uplot.Series(label=f"{name} {end}", stroke=stroke, width=2))
        return self._gui.add_uplot(
            tuple(np.zeros(1) for _ in series),
            tuple(series),
            title="tension at the ends [N] over time [s]",
            scales={"x": uplot.Scale(time=False)},
            legend=uplot.Legend(show=True, live=False),
            height=_HEIGHT,
        )

    def _add_buttons(self) -> None:
        simulation = self._simulation
        buttons = self._gui.add_button_group("simulation", ("halt or go on", _RESTART))

        @buttons.on_click
        def _(event: Any) -> None:
            if buttons.value == _RESTART:
                simulation.reset()
                self.draw()
            else:
                simulation.paused = not simulation.paused

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
