"""MuJoCo's response on the bench against the closed form of the 1991 paper.

K_ap and ξ_B follow from the tendon's elongation ξ_in − ξ_out against its output tension, a curve
that neither the mass nor the damping of the bench's carriages changes:
dT_out/d(ξ_in − ξ_out) = K_ap outside the backlash, and the line through it meets T_0 at ξ_B.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tendon_mj import theory
from tendon_mj.lab.progress import Progress, counted, silent
from tendon_mj.lab.replay import rollout_named_sensors
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray

SWING = 0.5  # of the output tension, over T_0, within which K_ap and ξ_B are read
_STEPS = 6000  # of a first motion
_SENSORS = ("input_tension", "output_tension", "reel_displacement", "output_displacement")
SWEEP = (0.05, 0.1, 0.2, 0.35, 0.47, 0.7, 1.0, 1.25, 1.5)
LIMIT_SWEEP = (0.05, 0.2, 0.47, 1.0, 1.5, 2.0, 3.0)
LIMIT_FACTOR = 100.0
LIMIT_GUIDES = 64
GUIDES = (2, 4, 8, 16, 32, 64)
FINEST_GUIDES = 1024


@dataclass(frozen=True)
class BenchReadings:
    """Readings of the bench's sensors while the reel follows a history, each (steps,) [N or m]."""

    input_tension: FloatArray
    output_tension: FloatArray
    reel_displacement: FloatArray
    output_displacement: FloatArray


def run_bench(bench: Bench, reel: FloatArray) -> BenchReadings:
    """Simulate the bench from rest under T_0 while its reel follows ``reel``, (steps,) [m]."""
    shown = rollout_named_sensors(build_bench(bench).compile(), reel)
    return BenchReadings(*(shown[name] for name in _SENSORS))


@dataclass(frozen=True)
class FirstMotion:
    """A first motion from uniform T_0 in one direction: measured values and the closed form's."""

    exponent: float  # λ with its sign, + pulling [-]
    # K_ap [N/m]
    apparent_stiffness: float
    analytic_stiffness: float
    # ξ_B [m]
    backlash: float
    analytic_backlash: float
    # their difference over T_in L/EA, T_in being the largest input tension until the output starts:
    # T_0 e^λ pulling, T_0 loosening
    backlash_error: float
    # T_out/T_in while sliding [-]
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


def first_motion(bench: Bench, direction: int) -> FirstMotion:
    """Pull (+1) or loosen (−1) the bench until T_out has changed by ``SWING`` T_0."""
    lam = direction * bench.exponent
    tension, ea, length = bench.pretension, bench.axial_stiffness, bench.length
    backlash = float(theory.equivalent_backlash(lam, tension, ea, length))
    stiffness = float(theory.apparent_stiffness(lam, ea, length))
    end = backlash + direction * 1.1 * SWING * tension / _transmission_stiffness(bench, lam)
    ramp = np.linspace(0.0, 1.0, _STEPS)
    loop = run_bench(bench, end * ramp**2 * (3.0 - 2.0 * ramp))
    change = direction * (loop.output_tension - tension) / tension
    used = (change > 0.3 * SWING) & (change < SWING)
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


def _transmission_stiffness(bench: Bench, exponent: float) -> float:
    """K_t in the closed form [N/m]."""
    ea, springs = bench.axial_stiffness, (bench.environment_stiffness, bench.sensor_stiffness)
    return float(theory.transmission_stiffness(exponent, ea, bench.length, *springs))


def _sweep(
    bench: Bench, exponents: Sequence[float], progress: Progress, label: str
) -> list[FirstMotion]:
    """First motions in both directions for each |λ|, which is set by the friction."""
    motions = []
    for exponent in counted(progress, label, exponents):
        changed = dataclasses.replace(bench, friction=exponent / bench.bend)
        motions += [first_motion(changed, direction) for direction in (1, -1)]
    return motions


@dataclass(frozen=True)
class Convergence:
    """Convergence of K_ap over the number of guides."""

    guides: FloatArray  # (k,) numbers of guides
    error: FloatArray  # (k,) |K_ap/K_ap(finest) − 1|
    order: float  # p of error ∝ guides^−p, least squares over all of them


def convergence(bench: Bench, progress: Progress = silent) -> Convergence:
    """Error of K_ap over the guides, relative to ``FINEST_GUIDES``: discretisation error alone."""
    # the stuck segment at the output end stiffens with the guides; so short a step follows it
    fine = dataclasses.replace(bench, timestep=1e-4)
    stiffness = []
    for guides in counted(progress, "convergence", (*GUIDES, FINEST_GUIDES)):
        motion = first_motion(dataclasses.replace(fine, guides=guides), 1)
        stiffness.append(motion.apparent_stiffness)
    error = np.abs(np.array(stiffness[:-1]) / stiffness[-1] - 1.0)
    order = -np.polyfit(np.log(GUIDES), np.log(error), 1)[0]
    return Convergence(np.array(GUIDES, float), error, float(order))


@dataclass(frozen=True)
class LargestErrors:
    """Largest error of a sweep."""

    exponent: float  # largest λ of the sweep [-]
    apparent_stiffness: float  # |K_ap/K_ap(closed form) − 1| [-]
    backlash: float  # |ξ_B − ξ_B(closed form)| over T_in L/EA [-]
    transmission: float  # |T_out/T_in/(closed form) − 1| while sliding [-]

    @classmethod
    def of(cls, motions: Sequence[FirstMotion]) -> LargestErrors:
        """Largest errors over first motions."""
        return cls(
            exponent=max(m.exponent for m in motions),
            apparent_stiffness=max(abs(m.stiffness_error) for m in motions),
            backlash=max(abs(m.backlash_error) for m in motions),
            transmission=max(abs(m.transmission_error) for m in motions),
        )

    def result(self) -> dict[str, dict[str, float]]:
        """Plain numbers for `result.json`."""
        return {
            "apparent_stiffness": {"max_relative_error": self.apparent_stiffness},
            "equivalent_backlash": {"max_relative_error": self.backlash},
            "transmission": {"max_relative_error": self.transmission},
        }


@dataclass(frozen=True)
class Comparison:
    """Results of `compare_bench`."""

    # parameters of the bench, and of the one in the stiff limit
    bench: Bench
    limit_bench: Bench
    loop: BenchReadings  # readings of a cycle and a quarter on the bench
    # sweeps of λ in both directions on either
    motions: list[FirstMotion]
    limit_motions: list[FirstMotion]
    convergence: Convergence  # over guides, at λ = 3 in the limit

    @property
    def transmission_stiffness(self) -> dict[int, float]:
        """Relative error of K_t, read off the loop, pulling (+1) and loosening (−1)."""
        return {direction: _slope_error(self.bench, self.loop, direction) for direction in (1, -1)}

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            **LargestErrors.of(self.motions).result(),
            "limit": LargestErrors.of(self.limit_motions).result(),
            "output_tension_swing": SWING,
            "transmission_stiffness": {
                "relative_error_pulling": self.transmission_stiffness[1],
                "relative_error_loosening": self.transmission_stiffness[-1],
            },
            "convergence_order": self.convergence.order,
            "motions": [_numbers(m) for m in self.motions],
            "limit_motions": [_numbers(m) for m in self.limit_motions],
        }


def _slope_error(bench: Bench, loop: BenchReadings, direction: int) -> float:
    """Slope of the loop's outer branch over K_t, less 1."""
    reel, output = loop.reel_displacement, loop.output_tension
    sliding = loop.input_tension * np.exp(-direction * bench.exponent)
    used = (np.abs(sliding / output - 1.0) < 1e-9) & (np.sign(np.gradient(reel)) == direction)
    slope = np.polyfit(reel[used] - reel[used].mean(), output[used], 1)[0]
    return float(slope / _transmission_stiffness(bench, direction * bench.exponent) - 1.0)


def _numbers(motion: FirstMotion) -> dict[str, float]:
    return {**dataclasses.asdict(motion), "stiffness_error": motion.stiffness_error}


def compare_bench(progress: Progress = silent) -> Comparison:
    """Compare the bench with the closed form: loops, sweep, limit, convergence."""
    bench = Bench()
    limit = dataclasses.replace(bench, guides=LIMIT_GUIDES).stiffened(LIMIT_FACTOR)
    # so slow that the carriages' damping does not show
    cycle = 1.5e-3 * np.sin(2.0 * np.pi * np.linspace(0.0, 1.25, 200_001))
    steep = dataclasses.replace(limit, friction=3.0 / bench.bend)
    return Comparison(
        bench=bench,
        limit_bench=limit,
        loop=run_bench(bench, cycle),
        motions=_sweep(bench, SWEEP, progress, "sweep of λ on the bench"),
        limit_motions=_sweep(limit, LIMIT_SWEEP, progress, "sweep of λ in the stiff limit"),
        convergence=convergence(steep, progress),
    )
