"""Comparison of MuJoCo's response on the bench with the closed form of the 1991 paper."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tendon_mj import theory
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.verification.first_motion import (
    SWING,
    BenchReadings,
    FirstMotion,
    first_motion,
    run_bench,
    sweep,
)
from tendon_mj.lab.verification.rollout_speedup import rollout_speedup
from tendon_mj.lab.verification.step_cost import bench_step_cost
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

SWEEP = (0.05, 0.1, 0.2, 0.35, 0.47, 0.7, 1.0, 1.25, 1.5)
LIMIT_SWEEP = (0.05, 0.2, 0.47, 1.0, 1.5, 2.0, 3.0)
LIMIT_FACTOR = 100.0
LIMIT_GUIDES = 64
GUIDES = (2, 4, 8, 16, 32, 64)
FINEST_GUIDES = 1024


@dataclass(frozen=True)
class Convergence:
    """Convergence of K_ap over the number of guides.

    Attributes:
        guides: (k,) numbers of guides.
        error: (k,) |K_ap/K_ap(finest) − 1|.
        order: p of error ∝ guides^−p, least squares over all of them.
    """

    guides: FloatArray
    error: FloatArray
    order: float


def convergence(bench: Bench, progress: Progress = silent) -> Convergence:
    """Error of K_ap over the guides, relative to ``FINEST_GUIDES``: discretisation error alone."""
    # the stuck segment at the output end stiffens with the guides; so short a step follows it
    fine = dataclasses.replace(bench, timestep=1e-4)
    stiffness = []
    counts = (*GUIDES, FINEST_GUIDES)
    for k, guides in enumerate(counts):
        progress("convergence", k, len(counts))
        motion = first_motion(dataclasses.replace(fine, guides=guides), 1)
        stiffness.append(motion.apparent_stiffness)
    progress("convergence", len(counts), len(counts))
    error = np.abs(np.array(stiffness[:-1]) / stiffness[-1] - 1.0)
    order = -np.polyfit(np.log(GUIDES), np.log(error), 1)[0]
    return Convergence(np.array(GUIDES, float), error, float(order))


@dataclass(frozen=True)
class LargestErrors:
    """Largest error of a sweep.

    Attributes:
        exponent: largest λ of the sweep [-].
        apparent_stiffness: |K_ap/K_ap(closed form) − 1| [-].
        backlash: |ξ_B − ξ_B(closed form)| over T_in L/EA [-].
        transmission: |T_out/T_in/(closed form) − 1| while sliding [-].
    """

    exponent: float
    apparent_stiffness: float
    backlash: float
    transmission: float

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
    """Results of `compare_bench`.

    Attributes:
        bench, limit_bench: parameters of the bench, and of the one in the stiff limit.
        loop: readings of a cycle and a quarter on the bench.
        motions, limit_motions: sweeps of λ in both directions on either.
        convergence: over guides, at λ = 3 in the limit.
        step_cost: time of a step over that of MuJoCo's own tendon [-].
        rollout_speedup: of rollouts on two threads over one [-].
    """

    bench: Bench
    limit_bench: Bench
    loop: BenchReadings
    motions: list[FirstMotion]
    limit_motions: list[FirstMotion]
    convergence: Convergence
    step_cost: float
    rollout_speedup: float

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
            "step_cost_ratio": self.step_cost,
            "rollout_speedup": self.rollout_speedup,
            "motions": [_numbers(m) for m in self.motions],
            "limit_motions": [_numbers(m) for m in self.limit_motions],
        }


def _slope_error(bench: Bench, loop: BenchReadings, direction: int) -> float:
    """Slope of the loop's outer branch over K_t, less 1."""
    reel, output = loop.reel_displacement, loop.output_tension
    sliding = loop.input_tension * np.exp(-direction * bench.exponent)
    used = (np.abs(sliding / output - 1.0) < 1e-9) & (np.sign(np.gradient(reel)) == direction)
    slope = np.polyfit(reel[used] - reel[used].mean(), output[used], 1)[0]
    analytic = theory.transmission_stiffness(
        direction * bench.exponent,
        bench.axial_stiffness,
        bench.length,
        bench.environment_stiffness,
        bench.sensor_stiffness,
    )
    return float(slope / analytic - 1.0)


def _numbers(motion: FirstMotion) -> dict[str, float]:
    return {**dataclasses.asdict(motion), "stiffness_error": motion.stiffness_error}


def slow_loop(bench: Bench) -> BenchReadings:
    """A cycle and a quarter of ±1.5 mm, so slow that the carriages' damping does not show."""
    return run_bench(bench, 1.5e-3 * np.sin(2.0 * np.pi * np.linspace(0.0, 1.25, 200_001)))


def compare_bench(bench: Bench | None = None, progress: Progress = silent) -> Comparison:
    """Compare the bench with the closed form: loops, sweep, limit, convergence, step cost.

    Args:
        bench: its parameters; default: those of the package's model.
        progress: called with what is being done, how much is done, and of how much.

    Raises:
        TendonError: a simulation became unstable.
        EngineError: rollouts on one thread and on two differ.
    """
    bench = bench or Bench()
    limit = dataclasses.replace(bench, guides=LIMIT_GUIDES).stiffened(LIMIT_FACTOR)
    steep = dataclasses.replace(limit, friction=3.0 / bench.bend)
    return Comparison(
        bench=bench,
        limit_bench=limit,
        loop=slow_loop(bench),
        motions=sweep(bench, SWEEP, progress, "sweep of λ on the bench"),
        limit_motions=sweep(limit, LIMIT_SWEEP, progress, "sweep of λ in the stiff limit"),
        convergence=convergence(steep, progress),
        step_cost=bench_step_cost(bench).ratio,
        rollout_speedup=rollout_speedup(bench),
    )
