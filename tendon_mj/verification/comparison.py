"""Holds MuJoCo's response on the bench against the closed form of the paper."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tendon_mj import theory
from tendon_mj.builders.bench import Bench
from tendon_mj.progress import Progress, silent
from tendon_mj.replay.rollout import Array
from tendon_mj.verification.first_motion import (
    SWING,
    Loop,
    Motion,
    first_motion,
    run_bench,
    sweep,
)
from tendon_mj.verification.step_cost import rollout_speedup, step_cost_ratio

SWEEP = (0.05, 0.1, 0.2, 0.35, 0.47, 0.7, 1.0, 1.25, 1.5)
LIMIT_SWEEP = (0.05, 0.2, 0.47, 1.0, 1.5, 2.0, 3.0)
LIMIT_FACTOR = 100.0
LIMIT_GUIDES = 64
GUIDES = (2, 4, 8, 16, 32, 64)
FINEST_GUIDES = 1024


@dataclass(frozen=True)
class Convergence:
    """How K_ap approaches its value at many guides.

    Attributes:
        guides: (k,) numbers of guides.
        error: (k,) |K_ap/K_ap(finest) − 1|.
        order: p of error ∝ guides^−p, least squares over all of them.
    """

    guides: Array
    error: Array
    order: float


def convergence(bench: Bench, progress: Progress = silent) -> Convergence:
    """Refine the guides and compare with ``FINEST_GUIDES``, so that all else drops out."""
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
class Comparison:
    """Everything that `compare` measures.

    Attributes:
        bench, limit_bench: what was measured.
        loop: a cycle and a quarter on the bench.
        motions, limit_motions: sweeps of λ in both directions.
        convergence: over guides, at λ = 3 in the limit.
        step_cost: ratio of step times.
        rollout_speedup: of rollouts on two threads over one.
    """

    bench: Bench
    limit_bench: Bench
    loop: Loop
    motions: list[Motion]
    limit_motions: list[Motion]
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
            **_errors(self.motions),
            "limit": _errors(self.limit_motions),
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


def _slope_error(bench: Bench, loop: Loop, direction: int) -> float:
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


def _numbers(motion: Motion) -> dict[str, float]:
    return {**dataclasses.asdict(motion), "stiffness_error": motion.stiffness_error}


def _errors(motions: list[Motion]) -> dict[str, dict[str, float]]:
    slid = [m.transmission / m.analytic_transmission - 1.0 for m in motions]
    return {
        "apparent_stiffness": {"max_relative_error": max(abs(m.stiffness_error) for m in motions)},
        "equivalent_backlash": {"max_relative_error": max(abs(m.backlash_error) for m in motions)},
        "transmission": {"max_relative_error": max(abs(e) for e in slid)},
    }


def slow_loop(bench: Bench) -> Loop:
    """A cycle and a quarter of ±1.5 mm, so slow that the carriages' damping does not show."""
    return run_bench(bench, 1.5e-3 * np.sin(2.0 * np.pi * np.linspace(0.0, 1.25, 200_001)))


def compare(bench: Bench | None = None, progress: Progress = silent) -> Comparison:
    """Measure the bench against the closed form: loops, sweep, limit, convergence, step cost."""
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
        step_cost=step_cost_ratio(bench),
        rollout_speedup=rollout_speedup(bench),
    )
