"""Recording of a reference: its readings with noise and quantisation."""

from __future__ import annotations

import numpy as np

from experiments.hidden_effects.references import excitation
from experiments.hidden_effects.references.bench import ReferenceBench
from experiments.hidden_effects.references.joint import ReferenceJoint
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.typing import FloatArray

QUANTISATION = 1.0 / 3.0  # step of the readings over their noise [-]


def noisy_recording(
    reference: ReferenceBench | ReferenceJoint,
    model: str,
    rng: np.random.Generator,
    name: str,
    drive: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
) -> Recording:
    """Readings with noise and quantisation as a recording that states no parameter.

    Args:
        reference: that was simulated.
        model: to which the recording refers.
        rng: of the noise.
        name: of the recording.
        drive: (samples,) in the drive's unit.
        readings: (sensors, samples) without noise.
        noise: (sensors,) standard deviations in the sensors' units.
    """
    stated = reference.description
    columns, measured = {stated.drive: drive}, {}
    sensors = zip(stated.sensors.items(), readings, noise, strict=True)
    for (column, sensor), values, sigma in sensors:
        digit = float(f"{QUANTISATION * sigma:.2g}")
        noisy = values + rng.normal(0.0, sigma, len(values))
        columns[column] = np.round(np.round(noisy / digit) * digit, 9)
        measured[column] = Measured(sensor, float(f"{sigma:.4g}"))
    rate = reference.rate
    return Recording(
        name=name,
        model=model,
        source="made by tendon-mj, not measured: experiments/hidden_effects; Apache-2.0",
        time=excitation.clock(len(drive) / rate, rate)[: len(drive)],
        columns=columns,
        drive={stated.drive: stated.actuator},
        measured=measured,
    )
