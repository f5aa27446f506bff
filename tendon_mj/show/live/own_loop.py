"""Shows a model and data of the user, moved by a function of the user."""

from __future__ import annotations

import mujoco

from tendon_mj.plugin import TENSION_SCALE
from tendon_mj.show.live.scene import first_view
from tendon_mj.show.live.session import LiveSimulation, Prepared, RealTime, Step
from tendon_mj.show.live.web import serve
from tendon_mj.show.live.window import open_window


def view(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    *,
    step: Step | None = None,
    web: bool = False,
    port: int = 8080,
    seconds: float | None = None,
) -> RealTime:
    """Show a simulation while it runs at the clock's pace, until its window is closed or Ctrl-C.

    ``data`` moves on from its present state, by the same numbers as in a loop without a view.
    `show_tension`, before the model is compiled, gives tendons the colours of their tension.

    Args:
        model: to simulate.
        data: its data, which are changed.
        step: called as ``step(model, data)`` before each time step, to set ``data.ctrl``: a policy.
            If it calls `mj_step` itself, no other step is made. By default the controls stay as
            they are, and the page has sliders for them.
        web: show it in a browser, instead of MuJoCo's viewer.
        port: of the page; if it is taken, the next free one.
        seconds: after which it ends [s]; by default it does not.

    Returns:
        Simulated time, time on the clock, and frames.

    Raises:
        EngineError: there is no screen.
        MissingPackageError: ``web`` needs the extra of that name.
        TendonError: the simulation became unstable.
    """
    simulation = LiveSimulation(model, None, data=data, step=step)
    scaled = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, TENSION_SCALE) >= 0
    low, high = model.numeric(TENSION_SCALE).data if scaled else (0.0, 0.0)
    prepared = Prepared(simulation, first_view(model), float(low), float(high), "")
    return serve(prepared, port=port, seconds=seconds) if web else open_window(prepared, seconds)
