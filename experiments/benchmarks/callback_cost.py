"""Cost of the plugin beside that of the same sheath as a NumPy `mjcb_passive`, on the bench."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from experiments.benchmarks.numpy_sheath import NumpySheath, as_passive_callback
from tendon_mj.attach import view_sheath
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.lab.verification import Spread
from tendon_mj.lab.verification.mujoco_tendon import mujoco_tendon_bench, without_tension_sensors
from tendon_mj.lab.verification.step_cost import TimedRun, run_along
from tendon_mj.lab.verification.timing import processor_time, times_in_turns
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray

TRAVEL = 1e-3  # of the reel [m]


@dataclass(frozen=True)
class CallbackCost:
    """Cost that a callback in Python adds to a step, over that of the plugin.

    Attributes:
        ratio: of what the two add, of each round [-].
        callback: added by the NumPy callback [s].
        plugin: added by the plugin [s].
        empty: added by a callback that does nothing [s].
        disagreement: largest difference of any segment's tension between the two, over the
            largest tension [-].
    """

    ratio: Spread
    callback: Spread
    plugin: Spread
    empty: Spread
    disagreement: float

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "ratio": self.ratio.result(),
            "callback_added_s": self.callback.result(),
            "plugin_added_s": self.plugin.result(),
            "empty_callback_added_s": self.empty.result(),
            "largest_tension_difference": self.disagreement,
        }


def bare_bench(bench: Bench) -> mujoco.MjSpec:
    """The bench with a tendon without any force, and an actuator that only shows its control."""
    spec = mujoco_tendon_bench(bench)
    spec.tendon("tendon").stiffness[0] = 0.0
    reel = spec.add_actuator(name="reel", trntype=mujoco.mjtTrn.mjTRN_TENDON, target="tendon")
    reel.gainprm[0] = 0.0
    return spec


def _run(bench: Bench, wave: FloatArray) -> tuple[TimedRun, TimedRun, NumpySheath]:
    plugin = run_along(without_tension_sensors(build_bench(bench)), wave)
    bare = run_along(bare_bench(bench), wave)
    return plugin, bare, NumpySheath(bare.model, bench)


def disagreement(bench: Bench, wave: FloatArray) -> float:
    """Largest difference of tensions between callback and plugin, over the largest tension [-].

    Args:
        bench: its parameters.
        wave: (steps,) tendon wound in [m].
    """
    plugin, bare, sheath = _run(bench, wave)
    view = view_sheath(plugin.model, plugin.data, "tendon")
    off, largest = 0.0, 0.0
    with as_passive_callback(sheath):  # of the process, so the plugin's model is stepped after
        ours = np.array([_stepped(bare, control, sheath) for control in wave])
    for control, tension in zip(wave, ours, strict=True):
        plugin.data.ctrl[0] = control
        mujoco.mj_step(plugin.model, plugin.data)
        off = max(off, float(np.abs(view.tension - tension).max()))
        largest = max(largest, float(tension.max()))
    return off / largest


def _stepped(run: TimedRun, control: float, sheath: NumpySheath) -> FloatArray:
    run.data.ctrl[0] = control
    mujoco.mj_step(run.model, run.data)
    return sheath.tension


def callback_cost(bench: Bench, *, rounds: int = 7, steps: int = 2000) -> CallbackCost:
    """Time the bench with the plugin, with the callback, with an empty one, and without a sheath.

    Args:
        bench: its parameters.
        rounds: in each of which all four run.
        steps: of a run, in which the reel goes to and fro twice.
    """
    wave = TRAVEL * np.sin(np.linspace(0.0, 4.0 * np.pi, steps))
    plugin, bare, sheath = _run(bench, wave)

    start = full_state(bare.model, bare.data)[None]
    plugin_start = full_state(plugin.model, plugin.data)[None]

    def roll() -> None:
        rollout_sensors(bare.model, [bare.data], start, bare.controls[None])

    def roll_plugin() -> None:
        rollout_sensors(plugin.model, [plugin.data], plugin_start, plugin.controls[None])

    def roll_numpy() -> None:
        sheath.reset()
        with as_passive_callback(sheath):
            roll()

    def roll_empty() -> None:
        with as_passive_callback(_nothing):
            roll()

    tasks = [roll, roll_plugin, roll_numpy, roll_empty]
    spent = times_in_turns(tasks, rounds, processor_time) / steps
    added = (spent[:, 1:] - spent[:, :1]).T
    return CallbackCost(
        ratio=Spread.of(added[1] / added[0]),
        plugin=Spread.of(added[0]),
        callback=Spread.of(added[1]),
        empty=Spread.of(added[2]),
        disagreement=disagreement(bench, wave),
    )


def _nothing(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """A callback that does nothing."""
