"""Cost of a sheath in a step of the bench, part by part: from an empty plugin to the sensors."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.lab.verification import Spread
from tendon_mj.lab.verification.mujoco_tendon import mujoco_tendon_bench, without_tension_sensors
from tendon_mj.lab.verification.step_cost import run_along, step_times
from tendon_mj.models import Bench, build_bench
from tendon_mj.plugin import NAME
from tendon_mj.typing import FloatArray

# MuJoCo's own, in its wheel; an instance that no body has does nothing when it is called
EMPTY_PLUGIN = "mujoco.elasticity.cable"
_COPIES = 100  # of an instance that costs too little to be timed alone
_STEPS = 4000  # so many that the caches, cold after another model, do not count
_TRAVEL = 1e-3  # of the reel [m]


@dataclass(frozen=True)
class CostParts:
    """Cost that each part adds to a step, on top of those before it.

    Attributes:
        empty_plugin: an instance of a plugin of MuJoCo's that does nothing; None where MuJoCo came
            without it [s].
        idle_instance: an instance of this plugin that finds nothing to do, beyond the above [s].
        first_guide: a sheath of one guide at rest, beyond the above [s].
        more_guides: the bench's other guides, at rest [s].
        sliding: that the tendon slides to and fro [s].
        sensors: the bench's three sensors with a number each [s].
        total: of all of these but the sensors [s].
    """

    empty_plugin: Spread | None
    idle_instance: Spread
    first_guide: Spread
    more_guides: Spread
    sliding: Spread
    sensors: Spread
    total: Spread

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            f"{field.name}_s": found.result() if found else None
            for field in dataclasses.fields(self)
            for found in (getattr(self, field.name),)
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
    """Whether MuJoCo came with ``EMPTY_PLUGIN``."""
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
        empty_plugin=Spread.of(empty) if "empty" in spent else None,
        idle_instance=Spread.of(idle - empty),
        first_guide=Spread.of(first - idle),
        more_guides=Spread.of(at_rest - first),
        sliding=Spread.of(spent["sliding"] - spent["rest"]),
        sensors=Spread.of(spent["sensors"] - spent["sliding"]),
        total=Spread.of(spent["sliding"] - spent["plain"]),
    )
