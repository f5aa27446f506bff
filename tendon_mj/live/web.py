"""A page that shows a simulation in a browser, with sliders for its live parameters."""

from __future__ import annotations

import copy
import importlib
import io
import socket
from collections.abc import Callable
from contextlib import redirect_stdout
from typing import Any

import numpy as np

from tendon_mj.errors import EngineError, MissingPackageError
from tendon_mj.live.first_view import FirstView
from tendon_mj.live.prepare import Prepared
from tendon_mj.live.real_time import RealTime, run_in_real_time
from tendon_mj.live.web_cable import WebCable
from tendon_mj.live.web_panel import WebPanel

HOST = "localhost"  # nobody else's browser: what it changes is not protected
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
        # the scene changes the scales of what it draws, so it has a copy of the model
        simulation = prepared.simulation
        scene = mjviser.ViserMujocoScene(server, copy.copy(simulation.model), num_envs=1)
        scene.camera_tracking_enabled = False
        server.gui.configure_theme(control_layout="fixed", control_width="large")
        server.on_client_connect(lambda client: _look(client.camera, prepared.view))
        page = _Page(scene, WebCable(server, simulation), WebPanel(server, viser, prepared))
        announce(f"http://{HOST}:{server.get_port()} shows the model; Ctrl-C ends it")
        return run_in_real_time(simulation, lambda: page.show(prepared), seconds)
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


def _check_free(port: int) -> None:
    """Refuse a port that something else serves; viser would silently take another."""
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
