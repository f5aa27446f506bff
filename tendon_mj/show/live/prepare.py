"""A model made ready to be watched: in motion, its tendons in colours that suit it."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco

from tendon_mj.attach import show_tension
from tendon_mj.errors import TendonError
from tendon_mj.models import load_spec, model_path
from tendon_mj.plugin import TENSION_SCALE, sheaths
from tendon_mj.show.live.first_view import FirstView, first_view
from tendon_mj.show.live.in_motion import in_motion, stands_still
from tendon_mj.show.live.simulation import LiveSimulation
from tendon_mj.show.live.tension_limits import tension_limits

_TRIAL = 8.0  # duration of the run that finds the colours' limits [s]


@dataclass(frozen=True)
class Prepared:
    """What is watched.

    Attributes:
        simulation: at its start.
        view: from where it is seen first.
        low, high: tensions at the ends of the colour bar [N]; both 0 without sheaths.
        still: why nothing moves; empty where something does.
    """

    simulation: LiveSimulation
    view: FirstView
    low: float
    high: float
    still: str


def prepare(name: str, motion: str | None = None) -> Prepared:
    """Load a model and set it in motion; see `in_motion` for ``motion``.

    Tendons are coloured between the tensions of the model's custom numeric
    `tendon_mj.tension_scale`, or, where it has none, those of a short run.

    Raises:
        UnknownNameError: no such model or motion.
        TendonError: the model does not compile, or becomes unstable.
    """
    spec, stem = load_spec(name, scene=True), model_path(name).stem
    has_scale = spec.numeric(TENSION_SCALE) is not None
    if not has_scale:
        show_tension(spec, 0.0, 1.0)  # until the limits are known
    try:
        compiled = spec.compile()
    except ValueError as error:
        raise TendonError(f"{model_path(name, scene=True)}: {error}") from error
    model, drive = in_motion(stem, compiled, motion)
    still, scale = stands_still(model, drive, _TRIAL), model.numeric(TENSION_SCALE).data
    if not sheaths(model):
        scale[:] = 0.0
    elif not has_scale:
        scale[:] = tension_limits(model, drive, _TRIAL)
    low, high = (float(limit) for limit in scale)
    return Prepared(LiveSimulation(model, drive), first_view(model), low, high, still)


def tendon_names(model: mujoco.MjModel) -> dict[str, str]:
    """Sheath → name of its tendon."""
    return {name: found.tendon for name, found in sheaths(model).items()}
