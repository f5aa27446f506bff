"""Cost of friction on every tendon of a model that somebody else wrote."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.attach import add_friction
from tendon_mj.errors import InvalidValueError, TendonError, TendonWarning
from tendon_mj.lab.replay import full_state, rollout_sensors, suppress_mujoco_log
from tendon_mj.lab.verification.controls import smooth_controls
from tendon_mj.lab.verification.memory import Memory
from tendon_mj.lab.verification.step_cost import StepCost, TimedRun, step_times
from tendon_mj.models import load_spec, model_path
from tendon_mj.plugin import sheaths

FRICTION = 0.1  # μ of every sheath
_STEPS = 500


@dataclass(frozen=True)
class ForeignModel:
    """A model without friction, with it, and with it but without the sensors of tension.

    Attributes:
        name: stem of its file.
        plain, sheathed, unsensed: the three, to be run with the same controls.
        sheaths: that it was given.
    """

    name: str
    plain: TimedRun
    sheathed: TimedRun
    unsensed: TimedRun
    sheaths: int


@dataclass(frozen=True)
class ModelCost:
    """Cost of friction in a model.

    Attributes:
        cost: of a step with sheaths, over one without.
        unsensed: the same without sensors of tension; None where `cost` has none either.
        sheaths: in the model.
        memory, reference_memory: of a simulation with sheaths, and without.
    """

    cost: StepCost
    unsensed: StepCost | None
    sheaths: int
    memory: Memory
    reference_memory: Memory

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            **self.cost.result(),
            "without_tension_sensors": self.unsensed.result() if self.unsensed else None,
            "sheaths": self.sheaths,
            "memory_bytes": self.memory.result(),
            "reference_memory_bytes": self.reference_memory.result(),
        }


def prepare_model(name: str, steps: int = _STEPS) -> ForeignModel:
    """Give every tendon of a model friction, and drive it with and without.

    Args:
        name: an MJCF file.
        steps: of a run.

    Raises:
        UnknownNameError: no such file.
        InvalidValueError: the model has no actuator, or no tendon that can have a sheath.
        TendonError: MuJoCo cannot read or compile it, or a run became unstable.
    """
    path = model_path(name)
    plain = _compiled(path, None)
    if plain.nu == 0:
        raise InvalidValueError(f"{path}: it has no actuator, so that nothing would move")
    controls = smooth_controls(plain, steps)
    models = (plain, _compiled(path, ("input_tension", "output_tension")), _compiled(path, ()))
    runs = [TimedRun(model, mujoco.MjData(model), controls) for model in models]
    for run in runs:
        _check_stable(run, path)
    bare, sheathed, unsensed = runs
    return ForeignModel(path.stem, bare, sheathed, unsensed, len(sheaths(sheathed.model)))


def _compiled(path: Path, sensors: Sequence[str] | None) -> mujoco.MjModel:
    """The model as it is, or with friction on every tendon."""
    spec = load_spec(str(path))
    try:
        if sensors is not None:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", TendonWarning)  # of tendons that are left out
                add_friction(spec, "*", friction=FRICTION, sensors=sensors)
        return spec.compile()
    except ValueError as error:  # MuJoCo's, and those of a model that cannot have friction
        raise TendonError(f"{path}: {error}") from error


def _check_stable(run: TimedRun, path: Path) -> None:
    what = f"with friction {FRICTION:g}" if sheaths(run.model) else "without friction"
    start = full_state(run.model, run.data)[None]
    with suppress_mujoco_log():
        rollout_sensors(run.model, [run.data], start, run.controls[None])
    if run.data.warning.number.any() or not np.isfinite(run.data.qpos).all():
        raise TendonError(
            f"{path}: the simulation became unstable, {what}, within {len(run.controls)} steps of "
            f"{run.model.opt.timestep:g} s"
        )


def model_cost(model: ForeignModel, rounds: int = 7) -> ModelCost:
    """Time the model's three runs in turns."""
    runs = (model.plain, model.sheathed, model.unsensed)
    plain, sheathed, unsensed = step_times(runs, rounds).T
    return ModelCost(
        cost=StepCost(sheathed, plain),
        unsensed=StepCost(unsensed, plain),
        sheaths=model.sheaths,
        memory=Memory.of(model.sheathed.model),
        reference_memory=Memory.of(model.plain.model),
    )
