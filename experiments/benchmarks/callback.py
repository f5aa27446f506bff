"""The sheath of the bench as a NumPy `mjcb_passive`, and its cost beside that of the plugin.

Segment j has the length ℓ_j and holds the unstretched length s_j, guide i bends by φ_i. Guides
that slide in a row tie the tensions of their segments, T_{j+1} = T_j e^{∓μφ}, and such a run as a
whole keeps its tendon: Σ ℓ_j/(1 + T_j/EA) = Σ s_j has one unknown. Newton's method finds it for
all runs at once. Which guides slide is taken from the step before and corrected until it agrees.
It is for a taut tendon with Coulomb friction alone.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.attach import view_sheath
from tendon_mj.errors import EngineError
from tendon_mj.lab.step_cost import (
    Quartiles,
    TimedRun,
    mujoco_tendon_bench,
    processor_time,
    run_along,
    times_in_turns,
    without_tension_sensors,
)
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray

TRAVEL = 1e-3  # of the reel [m]
_NO_TORQUE = np.zeros(3)
_PASSES = 1000  # corrections of the slip pattern
_TOGETHER = 20  # of which so many correct all guides at once, which may go in circles
_NEWTON = 20
_CLOSE = 1e-9  # last step of Newton's method in T/EA, whose square is the error that it leaves
_TOLERANCE = 1e-14  # of flows [m]
_ROUNDING = 1e-12  # of ratios of tensions


class NumpySheath:
    """Sheath of a bench whose one control is the tendon that has been wound in, under T_0 [m].

    Called by MuJoCo with model and data, it solves the tendon and adds its forces to
    `qfrc_passive`.

    Args:
        model: the bench with a tendon of MuJoCo's that has neither stiffness nor friction.
        bench: its parameters.

    Attributes:
        tension: (n+1,) of the latest evaluation [N].
        unsolved: evaluations whose slip pattern was not found.
    """

    def __init__(self, model: mujoco.MjModel, bench: Bench) -> None:
        start, count = int(model.tendon_adr[0]), int(model.tendon_num[0])
        self._sites = model.wrap_objid[start : start + count].copy()
        bodies = model.site_bodyid[self._sites]
        self._moving = [(int(k), int(bodies[k])) for k in np.flatnonzero(bodies)]
        self._friction = bench.friction
        self._stiffness = bench.axial_stiffness
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        self._strain = bench.pretension / bench.axial_stiffness
        self._laid = self._path(data)[0] / (1.0 + self._strain)
        self.reset()

    def reset(self) -> None:
        """Lay the tendon evenly along its path again."""
        self._time = -np.inf
        self._wound, self._new_wound = 0.0, 0.0
        self._stored, self._new_stored = self._laid, self._laid
        self._slip = np.zeros(len(self._laid) - 1)
        self._tau = np.full(len(self._laid), self._strain)
        self.tension = self._stiffness * self._tau
        self.unsolved = 0

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Add the sheath's forces to `qfrc_passive`; a new time commits the step before."""
        if data.time > self._time:
            self._time = data.time
            self._stored, self._wound = self._new_stored, self._new_wound
        lengths, directions, angles = self._path(data)
        self._new_wound = float(data.ctrl[0]) / (1.0 + self._strain)
        stored = self._stored.copy()
        stored[0] -= self._new_wound - self._wound
        self._new_stored, tau = self._solve(lengths, stored, self._friction * angles)
        self.tension = self._stiffness * tau
        along = self.tension[:, None] * directions
        for point, body in self._moving:  # between its two spans; an end has one
            pull = -along[point - 1] if point > 0 else np.zeros(3)
            if point < len(along):
                pull = pull + along[point]
            place = data.site_xpos[self._sites[point]]
            mujoco.mj_applyFT(model, data, pull, _NO_TORQUE, place, body, data.qfrc_passive)

    def _path(self, data: mujoco.MjData) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(n+1,) lengths [m], (n+1, 3) directions, (n,) bend angles [rad]."""
        points = data.site_xpos[self._sites]
        spans = points[1:] - points[:-1]
        lengths = np.sqrt((spans * spans).sum(axis=1))
        directions = spans / lengths[:, None]
        cosines = (directions[:-1] * directions[1:]).sum(axis=1)
        return lengths, directions, np.arccos(np.minimum(cosines, 1.0))

    def _solve(
        self, lengths: FloatArray, stored: FloatArray, exponents: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Unstretched lengths [m] and tensions over EA, with a slip pattern that they agree with.

        Args:
            lengths: ℓ [m].
            stored: unstretched lengths before anything flows [m].
            exponents: μφ of each guide [-].
        """
        slip, tau = self._slip, self._tau
        most = np.exp(exponents) * (1.0 + _ROUNDING)  # of the two tensions' ratio if it holds
        for done in range(_PASSES):
            holds, tau = _tension(lengths, stored, exponents, slip, tau)
            flow = (holds - stored).cumsum()[:-1]
            before, after = tau[:-1], tau[1:]
            pulled = 1.0 * (before > after * most) - 1.0 * (after > before * most)
            right = np.where(slip == 0.0, pulled, np.where(flow * slip < -_TOLERANCE, 0.0, slip))
            wrong = right != slip
            if not wrong.any():
                break
            if done >= _TOGETHER:
                wrong = wrong & (wrong.cumsum() == 1)
            slip = np.where(wrong, right, slip)
        else:
            self.unsolved += 1
        self._slip, self._tau = slip, tau
        return holds, tau


def _tension(
    lengths: FloatArray,
    stored: FloatArray,
    exponents: FloatArray,
    slip: FloatArray,
    guess: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Unstretched lengths [m] and tensions over EA for a slip pattern.

    Args:
        lengths, stored, exponents: see `NumpySheath._solve`.
        slip: +1 sliding towards the input, −1 towards the output, 0 at rest.
        guess: tensions over EA from which Newton's method starts.
    """
    rests = slip == 0.0
    first = np.append(0, rests.nonzero()[0] + 1)  # segment that each run of sliding guides begins
    run = np.append(0, rests.cumsum())
    fallen = np.append(0.0, (slip * exponents).cumsum())
    weights = np.exp(fallen[first][run] - fallen)  # tension over that of the run's first segment
    total = np.add.reduceat(stored, first)
    head = guess[first]
    for _ in range(_NEWTON):
        stretch = 1.0 + weights * head[run]
        holds = lengths / stretch
        missing = np.add.reduceat(holds, first) - total
        step = missing / np.add.reduceat(holds * weights / stretch, first)
        head = head + step
        if abs(step).max() < _CLOSE:
            break
    tau = weights * head[run]
    return lengths / (1.0 + tau), tau


@contextmanager
def as_passive_callback(callback: object) -> Iterator[None]:
    """Let MuJoCo call a function in every evaluation of passive forces, in this process.

    Raises:
        EngineError: the process has such a callback already.
    """
    if mujoco.get_mjcb_passive() is not None:
        raise EngineError("this process already has an mjcb_passive; remove it first")
    mujoco.set_mjcb_passive(callback)
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)


@dataclass(frozen=True)
class CallbackCost:
    """Cost that a callback in Python adds to a step, over that of the plugin.

    Attributes:
        ratio: of the two added costs, of each round [-].
        callback: added by the NumPy callback [s].
        plugin: added by the plugin [s].
        empty: added by a callback that does nothing [s].
        disagreement: largest difference of any segment's tension between the two, over the
            largest tension [-].
    """

    ratio: Quartiles
    callback: Quartiles
    plugin: Quartiles
    empty: Quartiles
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

    roll, roll_plugin = bare.from_now(), plugin.from_now()

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
        ratio=Quartiles.of(added[1] / added[0]),
        plugin=Quartiles.of(added[0]),
        callback=Quartiles.of(added[1]),
        empty=Quartiles.of(added[2]),
        disagreement=disagreement(bench, wave),
    )


def _nothing(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """A callback that does nothing."""
