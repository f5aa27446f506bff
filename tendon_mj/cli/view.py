"""`tendon-mj view`: MuJoCo's interactive viewer."""

from __future__ import annotations

from typing import Annotated

import tyro

from tendon_mj.builders.load import load_model
from tendon_mj.view.render.window import open_window


def view(model: Annotated[str, tyro.conf.Positional]) -> None:
    """Open a model in MuJoCo's interactive viewer; it needs a screen.

    Args:
        model: bench, joint, finger, finger_spring, or the path of an MJCF file.

    Example:
        tendon-mj view finger
    """
    open_window(load_model(model, scene=True))
