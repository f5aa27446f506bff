"""A page that shows a simulation in a browser, with sliders for its live parameters."""

from __future__ import annotations

import copy
import importlib
import io
import socket
from collections.abc import Callable
from contextlib import redirect_stdout
from typing import Any

import mujoco
import numpy as np

from tendon_mj.errors import EngineError, InvalidValueError, MissingPackageError
from tendon_mj.show.live.first_view import FirstView
from tendon_mj.show.live.prepare import Prepared
from tendon_mj.show.live.real_time import RealTime, run_in_real_time
from tendon_mj.show.live.web_cable import WebCable
from tendon_mj.show.live.web_panel import WebPanel

HOST = "localhost"  # nobody else's browser: what it changes is not protected
_LAST_PORT = 65535
_FLOOR, _THIN = 3.0, 1e-3  # half a plane's width and height over the model's extent
_EVERY = 4  # frames of the simulation for one of the scene
_RARELY = 8  # for new numbers and curves


def serve(
    prepared: Prepared,
    *,
    port: int = 8080,
    seconds: float | None = None,
    announce: Callable[[str], object] = print,
) -> RealTime:
    """Serve a simulation to browsers on this machine until Ctrl-C.

    Args:
        prepared: what is shown.
        port: of the page.
        seconds: after which to end [s]; None: never.
        announce: called with the page's address.

    Raises:
        MissingPackageError: mjviser is not installed.
        InvalidValueError: there is no such port.
        EngineError: the port is taken.
        TendonError: the simulation became unstable.
    """
    try:
        mjviser, viser = importlib.import_module("mjviser"), importlib.import_module("viser")
    except ImportError as error:
        raise MissingPackageError(
            f"`--web` needs mjviser ({error}); install it with pip install 'tendon-mj[web]'"
        ) from error
    _check_free(port)
    with redirect_stdout(io.StringIO()):  # it announces itself at length
        server = viser.ViserServer(host=HOST, port=port, label="tendon_mj", verbose=False)
    try:
        simulation = prepared.simulation
        scene = mjviser.ViserMujocoScene(server, _drawable(simulation.model), num_envs=1)
        scene.camera_tracking_enabled = False
        server.gui.configure_theme(control_layout="fixed", control_width="large")
        server.on_client_connect(lambda client: _look(client.camera, prepared.view))
        page = _Page(scene, WebCable(server, simulation), WebPanel(server, viser, prepared))
        announce(f"http://{HOST}:{server.get_port()} shows the model; Ctrl-C ends it")
        return run_in_real_time(simulation, lambda: page.show(prepared), seconds)
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


def _drawable(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy for the scene, which changes the scales of what it draws.

    Planes become flat boxes: the scene draws them without end, and as a veil before all the rest.
    Invisible sites go to a group that is not shown: it would draw them grey.
    """
    drawn = copy.copy(model)
    drawn.site_group[model.site_rgba[:, 3] == 0.0] = mujoco.mjNGROUP - 1
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE):
        width, depth = (size or _FLOOR * model.stat.extent for size in model.geom_size[geom, :2])
        drawn.geom_type[geom] = mujoco.mjtGeom.mjGEOM_BOX
        drawn.geom_size[geom] = width, depth, _THIN * model.stat.extent
    return drawn


def _check_free(port: int) -> None:
    """Refuse a port that something else serves; viser would silently take another."""
    if not 0 <= port <= _LAST_PORT:
        raise InvalidValueError(
            f"--port {port}: ports go from 0, any that is free, to {_LAST_PORT}"
        )
    with socket.socket() as probe:
        if probe.connect_ex((HOST, port)) == 0:
            raise EngineError(f"port {port} is taken; give another by --port")


def _look(camera: Any, view: FirstView) -> None:
    """Give a browser's camera a view."""
    camera.up_direction = (0.0, 0.0, 1.0)
    camera.position, camera.look_at = tuple(view.position), tuple(view.look_at)
    camera.fov, camera.near = float(np.radians(view.fovy)), 1e-3


class _Page:
    """Scene, tendons and panel, renewed frame by frame."""

    def __init__(self, scene: Any, cable: WebCable, panel: WebPanel) -> None:
        self._scene, self._cable, self._panel = scene, cable, panel
        self._frames = 0

    def show(self, prepared: Prepared) -> bool:
        """Show the simulation as it is now."""
        if self._frames % _EVERY == 0:
            with prepared.simulation.held():
                self._scene.update_from_mjdata(prepared.simulation.data)
            self._cable.draw()
        if self._frames % _RARELY == 0:
            self._panel.draw()
        self._frames += 1
        return True
