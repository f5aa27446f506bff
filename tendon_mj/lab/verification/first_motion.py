"""First motions of the bench in MuJoCo: K_ap and ξ_B measured from its sensors.

Both follow from the tendon's elongation ξ_in − ξ_out against its output tension, a curve that
neither the mass nor the damping of the bench's carriages changes: dT_out/d(ξ_in − ξ_out) = K_ap
outside the backlash, and the line through it meets T_0 at ξ_B.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tendon_mj import theory
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.replay import rollout_named_sensors
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray

SWING = 0.5  # of the output tension, over T_0, within which K_ap and ξ_B are read
SENSORS = ("input_tension", "output_tension", "reel_displacement", "output_displacement")


@dataclass(frozen=True)
class BenchReadings:
    """Readings of the bench's sensors while the reel follows a history, each (steps,) [N or m]."""

    input_tension: FloatArray
    output_tension: FloatArray
    reel_displacement: FloatArray
    output_displacement: FloatArray


def run_bench(bench: Bench, reel: FloatArray) -> BenchReadings:
    """Simulate the bench from rest under T_0 while its reel follows ``reel``, (steps,) [m].

    Raises:
        TendonError: the simulation became unstable.
    """
    shown = rollout_named_sensors(build_bench(bench).compile(), reel)
    return BenchReadings(*(shown[name] for name in SENSORS))


@dataclass(frozen=True)
class FirstMotion:
    """A first motion from uniform T_0 in one direction: measured values and the closed form's.

    Attributes:
        exponent: λ with its sign, + pulling [-].
        apparent_stiffness, analytic_stiffness: K_ap [N/m].
        backlash, analytic_backlash: ξ_B [m].
        backlash_error: their difference over T_in L/EA, T_in being the largest input tension until
            the output starts: T_0 e^λ pulling, T_0 loosening.
        transmission, analytic_transmission: T_out/T_in while sliding [-].
    """

    exponent: float
    apparent_stiffness: float
    analytic_stiffness: float
    backlash: float
    analytic_backlash: float
    backlash_error: float
    transmission: float
    analytic_transmission: float

    @property
    def stiffness_error(self) -> float:
        """Relative error of K_ap."""
        return self.apparent_stiffness / self.analytic_stiffness - 1.0

    @property
    def transmission_error(self) -> float:
        """Relative error of T_out/T_in."""
        return self.transmission / self.analytic_transmission - 1.0


def first_motion(
    bench: Bench, direction: int, *, swing: float = SWING, steps: int = 6000
) -> FirstMotion:
    """Measure a first motion: the reel winds until T_out has changed by ``swing`` T_0.

    Args:
        bench: with friction.
        direction: +1 pulls, −1 loosens.
        swing: change of the output tension over T_0 [-].
        steps: of the simulation.
    """
    lam = direction * bench.exponent
    tension, ea, length = bench.pretension, bench.axial_stiffness, bench.length
    backlash = float(theory.equivalent_backlash(lam, tension, ea, length))
    stiffness = float(theory.apparent_stiffness(lam, ea, length))
    total = float(
        theory.transmission_stiffness(
            lam, ea, length, bench.environment_stiffness, bench.sensor_stiffness
        )
    )
    end = backlash + direction * 1.1 * swing * tension / total
    ramp = np.linspace(0.0, 1.0, steps)
    loop = run_bench(bench, end * ramp**2 * (3.0 - 2.0 * ramp))
    change = direction * (loop.output_tension - tension) / tension
    used = (change > 0.3 * swing) & (change < swing)
    elongation = (loop.reel_displacement - loop.output_displacement)[used]
    output = loop.output_tension[used]
    slope, offset = np.polyfit(elongation - elongation.mean(), output, 1)
    measured_backlash = elongation.mean() + (tension - offset) / slope
    start_tension = tension * max(1.0, np.exp(lam))
    return FirstMotion(
        exponent=lam,
        apparent_stiffness=float(slope),
        analytic_stiffness=stiffness,
        backlash=float(measured_backlash),
        analytic_backlash=backlash,
        backlash_error=float((measured_backlash - backlash) / (start_tension * length / ea)),
        transmission=float(np.mean(output / loop.input_tension[used])),
        analytic_transmission=float(np.exp(-lam)),
    )


def sweep(
    bench: Bench, exponents: Sequence[float], progress: Progress = silent, label: str = "sweep"
) -> list[FirstMotion]:
    """First motions in both directions for each |λ|, which is set by the friction."""
    motions = []
    for k, exponent in enumerate(exponents):
        progress(label, k, len(exponents))
        changed = dataclasses.replace(bench, friction=exponent / bench.bend)
        motions += [first_motion(changed, direction) for direction in (1, -1)]
    progress(label, len(exponents), len(exponents))
    return motions
