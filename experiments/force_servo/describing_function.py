"""Describing-function prediction of the servo's limit cycle.

The sheath, driven by ξ = c + A sin φ, answers with T_out = T̄ + P sin φ + Q cos φ + …. What goes on
by itself under J θ̈ + G_v θ̇ = G_t r (T_r − T_out) has T̄ = T_r, J ω² A = G_t r² P and
G_v ω A = −G_t r² Q. The sheath is the flow solver without MuJoCo, without masses.
"""

from __future__ import annotations

import numpy as np

from experiments.force_servo.bench import Servo
from tendon_mj.builders.bench import Bench
from tendon_mj.sheath import Law, drive_displacement

_SAMPLES = 240  # of a period
_LARGEST, _SMALLEST, _FACTOR = 8.0, 0.3, 0.85  # amplitudes that are searched, over ξ_B


def _answer(bench: Bench, amplitude: float, centre: float) -> tuple[float, float, float]:
    """T̄ − T_0, P and Q [N] in the second period of the motion."""
    law = Law(
        axial_stiffness=bench.axial_stiffness,
        friction=bench.friction,
        pretension=bench.pretension,
    )
    phase = 2.0 * np.pi * np.arange(1, 2 * _SAMPLES + 1) / _SAMPLES
    response = drive_displacement(
        np.concatenate([[centre], centre + amplitude * np.sin(phase)]),
        law,
        length=bench.length,
        bend=bench.bend,
        guides=bench.guides,
        output_stiffness=bench.output_stiffness,
    )
    seen, phase = response.output_tension[-_SAMPLES:], phase[-_SAMPLES:]
    rest = float(seen.mean())
    sine, cosine = 2.0 * np.mean(seen * np.sin(phase)), 2.0 * np.mean(seen * np.cos(phase))
    return rest - bench.pretension, float(sine), float(cosine)


def _excess(bench: Bench, servo: Servo, amplitude: float) -> float:
    """G_v ω A + G_t r² Q: > 0 where the damping takes more than the sheath's lag gives."""
    low, high = -amplitude, amplitude
    for _ in range(24):  # T̄ rises with the centre
        centre = 0.5 * (low + high)
        mean, sine, cosine = _answer(bench, amplitude, centre)
        low, high = (centre, high) if mean < 0.0 else (low, centre)
    if sine <= 1e-9 * bench.pretension:
        return np.inf  # all of it within the backlash
    gain = servo.tension_gain * servo.radius**2
    frequency = np.sqrt(gain * sine / (servo.inertia * amplitude))
    return float(servo.velocity_gain * frequency * amplitude + gain * cosine)


def balance(bench: Bench, servo: Servo, backlash: float) -> float:
    """Amplitude of ξ_in in the stable limit cycle [m]; 0 where there is none.

    Args:
        bench, servo: with reference T_r = T_0.
        backlash: ξ_B, the scale of the search [m].
    """
    outer = _LARGEST * backlash
    while outer > _SMALLEST * backlash:
        inner = _FACTOR * outer
        if _excess(bench, servo, inner) < 0.0:
            for _ in range(14):
                middle = 0.5 * (inner + outer)
                if _excess(bench, servo, middle) < 0.0:
                    inner = middle
                else:
                    outer = middle
            return 0.5 * (inner + outer)
        outer = inner
    return 0.0
