"""Describing-function prediction of the servo's limit cycle.

The sheath, driven by ξ = c + A sin φ, responds with T_out = T̄ + P sin φ + Q cos φ + …. A limit
cycle of J θ̈ + G_v θ̇ = G_t r (T_r − T_out) has T̄ = T_r, J ω² A = G_t r² P and
G_v ω A = −G_t r² Q. The sheath is the flow solver without MuJoCo and without masses.
"""

from __future__ import annotations

import numpy as np

from experiments.force_servo.servo_bench import Servo
from experiments.sheath_bench import drive_sheath
from tendon_mj.models import Bench
from tendon_mj.sheath import Law

_SAMPLES = 240  # of a period
_LARGEST, _SMALLEST, _FACTOR = 8.0, 0.3, 0.85  # amplitudes searched over ξ_B, and their ratio


def _harmonics(bench: Bench, amplitude: float, centre: float) -> tuple[float, float, float]:
    """T̄ − T_0, P and Q in the second period of the motion [N]."""
    law = Law(
        axial_stiffness=bench.axial_stiffness,
        friction=bench.friction,
        pretension=bench.pretension,
    )
    phase = 2.0 * np.pi * np.arange(1, 2 * _SAMPLES + 1) / _SAMPLES
    response = drive_sheath(
        np.concatenate([[centre], centre + amplitude * np.sin(phase)]),
        law,
        length=bench.length,
        bend=bench.bend,
        guides=bench.guides,
        output_stiffness=bench.output_stiffness,
    )
    tension, phase = response.output_tension[-_SAMPLES:], phase[-_SAMPLES:]
    mean = float(tension.mean())
    sine, cosine = 2.0 * np.mean(tension * np.sin(phase)), 2.0 * np.mean(tension * np.cos(phase))
    return mean - bench.pretension, float(sine), float(cosine)


def _net_damping(bench: Bench, servo: Servo, amplitude: float) -> float:
    """G_v ω A + G_t r² Q [N m]: > 0 if the damping exceeds the energy that the lag feeds in."""
    low, high = -amplitude, amplitude
    for _ in range(24):  # T̄ rises with the centre
        centre = 0.5 * (low + high)
        mean, sine, cosine = _harmonics(bench, amplitude, centre)
        low, high = (centre, high) if mean < 0.0 else (low, centre)
    if sine <= 1e-9 * bench.pretension:
        return np.inf  # the whole motion is within the backlash
    gain = servo.tension_gain * servo.radius**2
    frequency = np.sqrt(gain * sine / (servo.inertia * amplitude))
    return float(servo.velocity_gain * frequency * amplitude + gain * cosine)


def predict_amplitude(bench: Bench, servo: Servo, backlash: float) -> float:
    """Amplitude of ξ_in in the stable limit cycle [m]; 0 if there is none.

    Args:
        bench, servo: with reference T_r = T_0.
        backlash: ξ_B, the scale of the search [m].
    """
    outer = _LARGEST * backlash
    while outer > _SMALLEST * backlash:
        inner = _FACTOR * outer
        if _net_damping(bench, servo, inner) < 0.0:
            for _ in range(14):
                middle = 0.5 * (inner + outer)
                if _net_damping(bench, servo, middle) < 0.0:
                    inner = middle
                else:
                    outer = middle
            return 0.5 * (inner + outer)
        outer = inner
    return 0.0
