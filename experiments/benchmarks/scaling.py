"""Cost of a step over the number of guides and over the number of sheaths, on the bench."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.verification import StepCost
from tendon_mj.lab.verification.mujoco_tendon import mujoco_tendon_bench, without_tension_sensors
from tendon_mj.lab.verification.step_cost import TimedRun, run_along, step_cost
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray

GUIDES = (4, 8, 16, 32, 64, 128, 256, 512)
FITTED_GUIDES = 16  # and more
SHEATHS = (1, 2, 5, 10, 20, 50, 100, 200)
SLOW, FAST = 0.5, 2.0  # of the reel, for the guides [Hz]
# The output's last span is half a segment long. Stuck, it is a spring on the carriage that the step
# must resolve (heavy carriages), and the output may not travel that far (stiff tendon and springs).
_STIFF, _HEAVY = 100.0, 25.0
_TRAVEL = 1e-3  # of the reel [m]; less by _STIFF on the stiff bench
_SHEATH_STEPS = 500


@dataclass(frozen=True)
class Scaling:
    """Added cost of a step over a count.

    Attributes:
        counts: (k,) how many.
        costs: of a step with so many, over MuJoCo's own tendons.
        exponent: p of added cost ∝ count^p, least squares over the logarithms.
    """

    counts: tuple[int, ...]
    costs: tuple[StepCost, ...]
    exponent: float

    @property
    def added(self) -> FloatArray:
        """(k, 3) lower quartile, median and upper quartile of what is added to a step [s]."""
        spreads = [cost.added for cost in self.costs]
        return np.array([[s.low, s.median, s.high] for s in spreads])

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "counts": list(self.counts),
            "exponent": self.exponent,
            "costs": [cost.result() for cost in self.costs],
        }


@dataclass(frozen=True)
class GuideScaling:
    """Added cost of a step over the guides, in a slow and in a fast motion.

    Attributes:
        slow, fast: the reel goes to and fro, and all guides slide both ways; exponents from 16
            guides on.
        marginal: exponent of what the guides beyond the first add in the slow motion, which leaves
            out the fixed cost of a sheath.
    """

    slow: Scaling
    fast: Scaling
    marginal: float

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "exponent_beyond_the_first_guide": self.marginal,
            "slow": {"frequency_Hz": SLOW, **self.slow.result()},
            "fast": {"frequency_Hz": FAST, **self.fast.result()},
        }


def exponent(counts: Sequence[int], added: Sequence[float]) -> float:
    """p of added ∝ count^p; nan where nothing was added."""
    if min(added) <= 0.0:
        return float("nan")
    return float(np.polyfit(np.log(counts), np.log(added), 1)[0])


def guide_runs(bench: Bench, guides: int, frequency: float) -> tuple[TimedRun, TimedRun]:
    """The bench with so many guides, and with MuJoCo's own tendon, along one cycle of the reel.

    Args:
        bench: its parameters but for the guides.
        guides: their number.
        frequency: of the reel [Hz].
    """
    heavy = dataclasses.replace(bench, guides=guides, mass=_HEAVY * bench.mass)
    stiff = heavy.stiffened(_STIFF)
    steps = round(1.0 / (frequency * bench.timestep))
    wave = _TRAVEL / _STIFF * np.sin(np.linspace(0.0, 2.0 * np.pi, steps))
    sheathed = without_tension_sensors(build_bench(stiff))
    return run_along(sheathed, wave), run_along(mujoco_tendon_bench(stiff), wave)


def guide_scaling(
    bench: Bench,
    guides: Sequence[int] = GUIDES,
    *,
    rounds: int = 7,
    progress: Progress = silent,
) -> GuideScaling:
    """Added cost of a step over the number of guides.

    Args:
        bench: its parameters but for the guides.
        guides: their numbers, rising.
        rounds: of which each times both models.
        progress: called with what is being done, how much is done, and of how much.
    """
    fitted = [k for k, n in enumerate(guides) if n >= FITTED_GUIDES]
    numbers = [guides[k] for k in fitted]
    one = step_cost(*guide_runs(bench, 1, SLOW), rounds=rounds).added.median
    scalings = []
    for done, frequency in enumerate((SLOW, FAST)):
        costs = []
        for k, count in enumerate(guides):
            progress("guides", done * len(guides) + k, 2 * len(guides))
            costs.append(step_cost(*guide_runs(bench, count, frequency), rounds=rounds))
        added = [costs[k].added.median for k in fitted]
        scalings.append(Scaling(tuple(guides), tuple(costs), exponent(numbers, added)))
    progress("guides", 2 * len(guides), 2 * len(guides))
    beyond = [scalings[0].costs[k].added.median - one for k in fitted]
    slow, fast = scalings
    return GuideScaling(slow, fast, exponent([n - 1 for n in numbers], beyond))


def several_benches(build: Callable[[], mujoco.MjSpec], count: int) -> mujoco.MjSpec:
    """So many copies of a model in one, each with its own tendon, carriages and sheath."""
    first = build()
    spec = mujoco.MjSpec()
    spec.option.timestep = first.option.timestep
    spec.option.gravity = first.option.gravity
    for k in range(count):
        copy = first if k == 0 else build()
        spec.attach(copy, prefix=f"bench{k}_", frame=spec.worldbody.add_frame())
    return spec


def sheath_scaling(
    bench: Bench,
    sheaths: Sequence[int] = SHEATHS,
    *,
    rounds: int = 7,
    progress: Progress = silent,
) -> Scaling:
    """Added cost of a step over the number of sheaths in one model.

    Args:
        bench: that every sheath is a copy of.
        sheaths: their numbers, rising.
        rounds: of which each times both models.
        progress: called with what is being done, how much is done, and of how much.
    """
    wave = _TRAVEL * np.sin(np.linspace(0.0, 2.0 * np.pi, _SHEATH_STEPS))
    builders: tuple[Callable[[], mujoco.MjSpec], ...] = (
        lambda: without_tension_sensors(build_bench(bench)),
        lambda: mujoco_tendon_bench(bench),
    )
    costs = []
    for k, count in enumerate(sheaths):
        progress("sheaths", k, len(sheaths))
        runs = [run_along(several_benches(build, count), wave) for build in builders]
        costs.append(step_cost(*runs, rounds=rounds))
    progress("sheaths", len(sheaths), len(sheaths))
    medians = [cost.added.median for cost in costs]
    return Scaling(tuple(sheaths), tuple(costs), exponent(sheaths, medians))
