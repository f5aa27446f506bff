"""A carriage with known friction behind its servo, measured as the file is."""

from __future__ import annotations

import numpy as np

from experiments.positioning_system import published
from experiments.positioning_system.descriptions import MODELS
from experiments.positioning_system.measurement import Measurement
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Simulator

CYCLES, PERIOD = 2, 2.0  # [s]
NOISE = 1e-8, 0.1  # of position [m] and force [N]


def synthetic() -> Measurement:
    """Cycles back and forth with the published numbers, the offset apart."""
    time = np.arange(0.0, CYCLES * PERIOD, 1e-3)
    reference = 0.03 * (1.0 - np.cos(2.0 * np.pi * time / PERIOD))
    blank = Recording(
        name="synthetic",
        model=str(MODELS / "servo.xml"),
        source="simulated",
        time=time,
        columns={"reference_m": reference, "position_m": 0.0 * time, "motor_force_N": 0.0 * time},
        drive={"reference_m": "servo"},
        measured={"position_m": Measured("position"), "motor_force_N": Measured("force")},
    )
    (series,) = Simulator([blank])([{**published.PARAMETERS, "gravity.x": 0.0}])[0]
    random = np.random.default_rng(4)
    position, force = (
        column + random.normal(0.0, noise, time.size)
        for column, noise in zip(series.values(), NOISE, strict=True)
    )
    return Measurement(time, reference, position, force)
