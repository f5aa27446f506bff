"""Fit of the MuJoCo model by `mujoco.sysid` alone, from one start, with its own weights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from experiments.measured_joint.prediction import Predict, Series
from experiments.measured_joint.wound_in import WoundIn
from tendon_mj import Uncertain, fit_with_sysid
from tendon_mj.lab.recordings import Recording

_FRICTION: Mapping[str, Uncertain] = {"sheath_*.friction": Uncertain(0.1, 0.0, 1.0)}


def fit_as_described(train: Sequence[Recording], seed: int = 0) -> Predict:
    """Fit the uncertain parameters; the sheath has no friction."""
    result = fit_with_sysid(train, train, simulator=WoundIn)
    values = {name: value for name, (value, _, _) in result.values.items()}

    def predict(recording: Recording) -> Series:
        return WoundIn([recording])([values])[0][0]

    return predict


def fit_told_of_friction(train: Sequence[Recording], seed: int = 0) -> Predict:
    """The same with the sheath's friction as one of them."""
    return fit_as_described(
        [replace(r, uncertain={**r.uncertain, **_FRICTION}) for r in train], seed
    )
