"""The whole benchmark: the cost of steps, its scaling, threads, memory, and what else one has."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from experiments.benchmarks.callback_cost import CallbackCost, callback_cost
from experiments.benchmarks.cost_parts import CostParts, cost_parts
from experiments.benchmarks.frictionloss import Frictionloss, compare_frictionloss
from experiments.benchmarks.scaling import (
    GUIDES,
    SHEATHS,
    GuideScaling,
    Scaling,
    guide_scaling,
    sheath_scaling,
)
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import tap
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.verification import ModelCost, Spread, bench_step_cost, finger_step_cost
from tendon_mj.lab.verification.foreign_model import model_cost, prepare_model
from tendon_mj.lab.verification.memory import Memory
from tendon_mj.lab.verification.mujoco_tendon import (
    mujoco_tendon_bench,
    mujoco_tendon_finger,
    without_tension_sensors,
)
from tendon_mj.lab.verification.rollout_speedup import thread_speedups
from tendon_mj.models import Bench, Finger, build_bench, build_finger

OWN = ("bench", "finger")  # models of the package that are always measured
_TWO = 2  # threads whose speedup is the figure; more where the machine has the cores


@dataclass(frozen=True)
class Benchmark:
    """Results of `run_benchmark`.

    Attributes:
        models: name → cost of a step and memory, `bench` and `finger` first.
        guides, sheaths: scaling of the added cost.
        threads: number → speedup of rollouts over one thread.
        parts: of what a sheath adds on the bench.
        callback: the plugin beside a NumPy `mjcb_passive`.
        frictionloss: the plugin beside MuJoCo's own.
    """

    models: dict[str, ModelCost]
    guides: GuideScaling
    sheaths: Scaling
    threads: dict[int, Spread]
    parts: CostParts
    callback: CallbackCost
    frictionloss: Frictionloss

    @property
    def thread_speedup(self) -> Spread:
        """Speedup of rollouts by a second thread [-]."""
        return self.threads[_TWO]

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "step_cost_ratio": {name: model.cost.ratio for name, model in self.models.items()},
            "guide_scaling_exponent": self.guides.slow.exponent,
            "sheath_scaling_exponent": self.sheaths.exponent,
            "thread_speedup": self.thread_speedup.median,
            "callback_ratio": self.callback.ratio.median,
            "models": {name: model.result() for name, model in self.models.items()},
            "guide_scaling": self.guides.result(),
            "sheath_scaling": self.sheaths.result(),
            "threads": {str(count): found.result() for count, found in self.threads.items()},
            "cost_parts": self.parts.result(),
            "callback": self.callback.result(),
            "frictionloss": self.frictionloss.result(),
            "cores": os.cpu_count(),
        }


def bench_cost(rounds: int) -> ModelCost:
    """Cost of the package's bench."""
    bench = Bench()
    return ModelCost(
        cost=bench_step_cost(bench, rounds=rounds),
        unsensed=None,
        sheaths=1,
        memory=Memory.of(without_tension_sensors(build_bench(bench)).compile()),
        reference_memory=Memory.of(mujoco_tendon_bench(bench).compile()),
    )


def finger_cost(rounds: int) -> ModelCost:
    """Cost of the package's finger, tapping."""
    finger = Finger()
    return ModelCost(
        cost=finger_step_cost(tap(), finger, rounds=rounds),
        unsensed=None,
        sheaths=2,
        memory=Memory.of(without_tension_sensors(build_finger(finger)).compile()),
        reference_memory=Memory.of(mujoco_tendon_finger(finger).compile()),
    )


def run_benchmark(
    models: Sequence[str] = (),
    *,
    rounds: int = 15,
    guides: Sequence[int] = GUIDES,
    sheaths: Sequence[int] = SHEATHS,
    progress: Progress = silent,
) -> Benchmark:
    """Measure what sheaths cost, each time in turns with the same model without.

    Args:
        models: MJCF files, to every tendon of which friction is added.
        rounds: of every measurement, ≥ 1.
        guides, sheaths: numbers over which the cost is measured.
        progress: called with what is being done, how much is done, and of how much.

    Raises:
        InvalidValueError: no rounds, two models of one name, or one that nothing drives.
        TendonError: a model that cannot be read, cannot have friction, or becomes unstable.
        EngineError: rollouts differ between numbers of threads.
    """
    if rounds < 1:
        raise InvalidValueError(f"rounds = {rounds} must be 1 or more")
    prepared = [prepare_model(name) for name in models]
    names = Counter([*OWN, *(model.name for model in prepared)])
    for name, count in names.items():
        if count > 1:
            raise InvalidValueError(
                f"{count} models are called {name!r}: result.json goes by the names of the files"
            )
    costs = {}
    for done, name in enumerate(names):
        progress("models", done, len(names))
        if name in OWN:
            costs[name] = (bench_cost if name == OWN[0] else finger_cost)(rounds)
        else:
            costs[name] = model_cost(prepared[done - len(OWN)], rounds)
    progress("models", len(names), len(names))
    bench = Bench()
    cores = os.cpu_count() or 1
    counts = [_TWO, *(n for n in (4, 8) if n <= cores)]
    return Benchmark(
        models=costs,
        guides=guide_scaling(bench, guides, rounds=rounds, progress=progress),
        sheaths=sheath_scaling(bench, sheaths, rounds=rounds, progress=progress),
        threads=thread_speedups(bench, counts, rounds=rounds),
        parts=cost_parts(bench, rounds=rounds),
        callback=callback_cost(bench, rounds=rounds),
        frictionloss=compare_frictionloss(bench, rounds=rounds),
    )
