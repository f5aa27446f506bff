"""Whether a recording's description or the model says the values of a simulation."""

from __future__ import annotations

from typing import Literal

import mujoco

from tendon_mj.cli.output import console
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import read_intervals

ValuesOf = Literal["description", "model"]


def applied(values_of: ValuesOf | None, recording: Recording, model: mujoco.MjModel) -> bool | None:
    """The option as ``described`` of `replay_recording`.

    Where a diagnosis wrote the model, and the description has other values, the console says which
    of them are used.
    """
    found = read_intervals(model)
    if found and values_of != "model" and (recording.known or recording.uncertain):
        name, first = recording.name, next(iter(found))
        console.print(
            f"{name}: what a diagnosis found and wrote into the model, such as {first}, is kept"
            f" over the description (--values-of description overrules it)"
            if values_of is None
            else f"warning: {name}: the description overrules what a diagnosis found and wrote into"
            f" the model, such as {first}; without --values-of description it is kept",
            soft_wrap=True,
        )
    return None if values_of is None else values_of == "description"
