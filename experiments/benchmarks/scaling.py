"""Cost of a step over guides and over sheaths, and part by part, on the bench."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.step_cost import (
    Quartiles,
    StepCost,
    TimedRun,
    mujoco_tendon_bench,
    run_along,
    step_times,
    without_tension_sensors,
)
from tendon_mj.models import Bench, build_bench
from tendon_mj.plugin import NAME
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
# MuJoCo's own, in its wheel; an instance that no body has does nothing when it is called
EMPTY_PLUGIN = "mujoco.elasticity.cable"
_COPIES = 100  # of an instance that costs too little to be timed alone
_STEPS = 4000  # so many that the caches, cold after another model, do not count


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
        """(k, 3) lower quartile, median and upper quartile of the added cost [s]."""
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
        marginal: exponent of the cost of the guides beyond the first in slow motion, which leaves
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
    """p of added ∝ count^p; nan if nothing was added."""
    if min(added) <= 0.0:
        return float("nan")
    return float(np.polyfit(np.log(counts), np.log(added), 1)[0])


def step_cost(run: TimedRun, reference: TimedRun, *, rounds: int = 7) -> StepCost:
    """Time two runs in turns, and divide by their steps."""
    return StepCost(*step_times((run, reference), rounds).T)


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
        progress: called with the stage, the number done and the total.
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
        progress: called with the stage, the number done and the total.
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


@dataclass(frozen=True)
class CostParts:
    """Cost that each part adds to a step, on top of those before it.

    Attributes:
        empty_plugin: an instance of a plugin of MuJoCo's that does nothing; None if MuJoCo came
            without it [s].
        idle_instance: an instance of this plugin that finds nothing to do, beyond the above [s].
        first_guide: a sheath of one guide at rest, beyond the above [s].
        more_guides: the bench's other guides, at rest [s].
        sliding: that the tendon slides to and fro [s].
        sensors: the bench's three sensors with a number each [s].
        total: of all of these but the sensors [s].
    """

    empty_plugin: Quartiles | None
    idle_instance: Quartiles
    first_guide: Quartiles
    more_guides: Quartiles
    sliding: Quartiles
    sensors: Quartiles
    total: Quartiles

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            f"{field.name}_s": result.result() if result else None
            for field in dataclasses.fields(self)
            for result in (getattr(self, field.name),)
        }


def with_instances(
    spec: mujoco.MjSpec, plugin: str, config: dict[str, str], count: int
) -> mujoco.MjSpec:
    """A model with so many more instances of a plugin."""
    spec.activate_plugin(plugin)
    for k in range(count):
        added = spec.add_plugin(name=f"instance{k}", plugin_name=plugin, active=True)
        added.config = config
    return spec


def has_empty_plugin() -> bool:
    """Return whether MuJoCo came with ``EMPTY_PLUGIN``."""
    try:
        _with_empty_plugins(Bench(guides=1)).compile()
    except ValueError:
        return False
    return True


def _with_empty_plugins(bench: Bench) -> mujoco.MjSpec:
    nothing = {"twist": "0", "bend": "0"}
    return with_instances(mujoco_tendon_bench(bench), EMPTY_PLUGIN, nothing, _COPIES)


def _with_idle_instances(bench: Bench) -> mujoco.MjSpec:
    """A sheath, and instances that would show something of it to sensors which are not there."""
    shown = {"tendon": "tendon", "sensor": "unsolved"}
    return with_instances(without_tension_sensors(build_bench(bench)), NAME, shown, _COPIES)


def cost_parts(bench: Bench, *, rounds: int = 7) -> CostParts:
    """Time models that have one part more each, all in every round.

    Args:
        bench: its parameters.
        rounds: of which each times every model.
    """
    one = dataclasses.replace(bench, guides=1)
    rest = np.zeros(_STEPS)
    motion = _TRAVEL * np.sin(np.linspace(0.0, 4.0 * np.pi, _STEPS))

    def sheathed(which: Bench) -> mujoco.MjSpec:
        return without_tension_sensors(build_bench(which))

    models: dict[str, tuple[Callable[[Bench], mujoco.MjSpec], Bench, FloatArray]] = {
        "plain": (mujoco_tendon_bench, bench, rest),
        "plain one": (mujoco_tendon_bench, one, rest),
        "idle": (_with_idle_instances, bench, rest),
        "one": (sheathed, one, rest),
        "rest": (sheathed, bench, rest),
        "sliding": (sheathed, bench, motion),
        "sensors": (build_bench, bench, motion),
    }
    if has_empty_plugin():
        models["empty"] = (_with_empty_plugins, bench, rest)
    runs = [run_along(build(which), wave) for build, which, wave in models.values()]
    return parts_of(dict(zip(models, step_times(runs, rounds).T, strict=True)))


def parts_of(spent: Mapping[str, FloatArray]) -> CostParts:
    """Parts from the (rounds,) times of a step of each model [s]; see `cost_parts`."""
    empty = (
        (spent["empty"] - spent["plain"]) / _COPIES
        if "empty" in spent
        else np.zeros_like(spent["plain"])
    )
    idle = (spent["idle"] - spent["rest"]) / _COPIES
    first = spent["one"] - spent["plain one"]
    at_rest = spent["rest"] - spent["plain"]
    return CostParts(
        empty_plugin=Quartiles.of(empty) if "empty" in spent else None,
        idle_instance=Quartiles.of(idle - empty),
        first_guide=Quartiles.of(first - idle),
        more_guides=Quartiles.of(at_rest - first),
        sliding=Quartiles.of(spent["sliding"] - spent["rest"]),
        sensors=Quartiles.of(spent["sensors"] - spent["sliding"]),
        total=Quartiles.of(spent["sliding"] - spent["plain"]),
    )
