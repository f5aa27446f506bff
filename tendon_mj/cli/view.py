"""`tendon-mj view`: a model in motion, in MuJoCo's viewer or in a browser."""

from __future__ import annotations

from typing import Annotated

import tyro

from tendon_mj.cli.output import console
from tendon_mj.errors import InvalidValueError
from tendon_mj.show.live import open_window, prepare, serve


def view(
    model: Annotated[str, tyro.conf.Positional],
    motion: str | None = None,
    web: bool = False,
    port: int = 8080,
    seconds: float | None = None,
) -> None:
    """Watch a model move, its tendons coloured by their tension, with the tensions as curves.

    Args:
        model: bench, joint, finger, finger_spring, or the path of an MJCF file.
        motion: of the finger: curl, tap, press, hold or a CSV of joint angles or tensions; of any
            other model a CSV with time_s and a column for each actuator.
        web: whether to serve a page for a browser, with sliders for friction and all other live
            parameters, instead of opening MuJoCo's viewer, which needs a screen.
        port: of that page.
        seconds: after which to end; by default when the window is closed, or at Ctrl-C.

    Example:
        tendon-mj view finger --motion press --web
    """
    if seconds is not None and not seconds > 0.0:
        raise InvalidValueError(f"--seconds {seconds:g} must be greater than 0")
    prepared = prepare(model, motion)
    if prepared.still:
        console.print(f"{model} does not move: {prepared.still}", soft_wrap=True)
    if web:
        done = serve(prepared, port=port, seconds=seconds, announce=console.print)
    else:
        done = open_window(prepared, seconds)
    console.print(done.sentence(), soft_wrap=True)
