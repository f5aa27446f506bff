"""Cost of a step with sheaths over one of the same model without.

A machine's speed drifts, so models are timed in turns: every round times all that is compared, and
a ratio or a difference is that of one round. The counterparts of bench and finger have MuJoCo's own
spatial tendons, of stiffness EA/S and spring length S, the length without tension, and no friction.
"""

from __future__ import annotations

import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach import add_friction, remove_friction
from tendon_mj.errors import InvalidValueError, TendonError, TendonWarning
from tendon_mj.lab.finger import prepare_finger, tap
from tendon_mj.lab.progress import Progress, counted, silent
from tendon_mj.lab.replay import full_state, rollout_sensors, suppress_mujoco_log
from tendon_mj.models import (
    TENDONS,
    Bench,
    Finger,
    build_bench,
    build_finger,
    load_spec,
    model_path,
)
from tendon_mj.plugin import sheaths
from tendon_mj.typing import FloatArray

FRICTION = 0.1  # μ of the sheaths that a given model gets
_FINE = 1e-6  # resolution that a clock of processor time must have [s]
_TRAVEL = 1e-3  # of the bench's reel [m]
_BENCH_STEPS = 8000
_STEPS = 500  # of a given model
_WAVES = 3  # sines in the control of an actuator
_FREQUENCIES = (0.2, 1.5)  # their range [Hz]


@dataclass(frozen=True)
class Quartiles:
    """Median, lower quartile and upper quartile of several rounds."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: FloatArray) -> Quartiles:
        """Spread over the rounds, (rounds,)."""
        low, median, high = np.quantile(values, (0.25, 0.5, 0.75))
        return cls(float(median), float(low), float(high))

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {"median": self.median, "quartiles": [self.low, self.high]}


@dataclass(frozen=True)
class StepCost:
    """Processor time of a step, in rounds that each time both models."""

    steps: FloatArray  # (rounds,) with sheaths [s]
    reference_steps: FloatArray  # (rounds,) of the same model without [s]

    @property
    def step(self) -> float:
        """Median with sheaths [s]."""
        return float(np.median(self.steps))

    @property
    def reference_step(self) -> float:
        """Median without sheaths [s]."""
        return float(np.median(self.reference_steps))

    @property
    def ratios(self) -> Quartiles:
        """Cost of a step over that of the reference, of each round [-]."""
        return Quartiles.of(self.steps / self.reference_steps)

    @property
    def ratio(self) -> float:
        """Median of the ratios [-]."""
        return self.ratios.median

    @property
    def added(self) -> Quartiles:
        """Cost that the sheaths add to a step, of each round [s]."""
        return Quartiles.of(self.steps - self.reference_steps)

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "ratio": self.ratio,
            "quartiles": self.ratios.result()["quartiles"],
            "step_s": self.step,
            "reference_step_s": self.reference_step,
            "added_s": self.added.result(),
            "rounds": len(self.steps),
        }


class TimedRun(NamedTuple):
    """A model, the data that it starts from, and its (steps, nu) controls."""

    model: mujoco.MjModel
    data: mujoco.MjData
    controls: FloatArray

    def from_now(self) -> Callable[[], object]:
        """Function that steps the model through its controls from its data's present state."""
        start = full_state(self.model, self.data)[None]
        return partial(rollout_sensors, self.model, [self.data], start, self.controls[None])


def run_along(spec: mujoco.MjSpec, wave: FloatArray) -> TimedRun:
    """A run in which every actuator of a model follows ``wave``, (steps,)."""
    model = spec.compile()
    return TimedRun(model, mujoco.MjData(model), np.tile(wave[:, None], (1, model.nu)))


def processor_time() -> float:
    """Processor time of the calling thread [s], which other processes do not lengthen.

    Wall time where the system counts it only in ticks of its scheduler.
    """
    fine = time.get_clock_info("thread_time").resolution <= _FINE
    return time.thread_time() if fine else time.perf_counter()


def times_in_turns(
    tasks: Sequence[Callable[[], object]],
    rounds: int,
    clock: Callable[[], float] = time.perf_counter,
) -> FloatArray:
    """(rounds, tasks) times [s]; every round runs each task once, in order."""
    spent = np.empty((rounds, len(tasks)))
    for times in spent:
        for k, task in enumerate(tasks):
            before = clock()
            task()
            times[k] = clock() - before
    return spent


def step_times(runs: Sequence[TimedRun], rounds: int) -> FloatArray:
    """(rounds, runs) processor time of a step [s]; every round makes each run once."""
    spent = times_in_turns([run.from_now() for run in runs], rounds, processor_time)
    return spent / [len(run.controls) for run in runs]


def smooth_controls(
    model: mujoco.MjModel, steps: int, seed: int = 0, amplitude: float = 1.0
) -> FloatArray:
    """(steps, nu) sums of sines within the control ranges; ±1 if an actuator has none.

    ``amplitude`` is over half the range, around its middle.
    """
    random = np.random.default_rng(seed)
    instants = model.opt.timestep * np.arange(steps)
    shape = (model.nu, _WAVES)
    phase, rate = random.uniform(0.0, 2.0 * np.pi, shape), random.uniform(*_FREQUENCIES, shape)
    share = np.sin(2.0 * np.pi * rate * instants[:, None, None] + phase).mean(axis=-1)
    limited = model.actuator_ctrllimited.astype(bool)
    low, high = model.actuator_ctrlrange.T
    centre = np.where(limited, 0.5 * (low + high), 0.0)
    half = np.where(limited, 0.5 * (high - low), 1.0)
    return np.asarray(centre + half * amplitude * share)


def memory_of(model: mujoco.MjModel) -> dict[str, int]:
    """Memory of one simulation [bytes]: state of the sheaths, buffer with it, arena, rollout state.

    ``total`` is buffer and arena, which MuJoCo reserves for contacts, constraints and the stack;
    ``state`` is one of kind FULLPHYSICS, from which rollouts start.
    """
    data = mujoco.MjData(model)
    number = np.dtype(np.float64).itemsize
    return {
        "plugin_state": number * int(model.npluginstate),
        "buffer": int(data.nbuffer),
        "arena": int(data.narena),
        "total": int(data.nbuffer) + int(data.narena),
        "state": number * mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS),
    }


@dataclass(frozen=True)
class ModelCost:
    """Cost of friction in a model."""

    cost: StepCost  # of a step with sheaths, over one without
    # the same without sensors of tension; None if cost has none either
    unsensed: StepCost | None
    sheaths: int  # in the model
    # of a simulation with sheaths, and without; see memory_of
    memory: dict[str, int]
    reference_memory: dict[str, int]

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            **self.cost.result(),
            "without_tension_sensors": self.unsensed.result() if self.unsensed else None,
            "sheaths": self.sheaths,
            "memory_bytes": self.memory,
            "reference_memory_bytes": self.reference_memory,
        }


class PreparedModel(NamedTuple):
    """Runs of a model without sheaths, with them, and with them but without sensors of tension.

    The last is None if the second has no such sensors either.
    """

    plain: TimedRun
    sheathed: TimedRun
    unsensed: TimedRun | None = None

    def cost(self, rounds: int = 7) -> ModelCost:
        """Time the runs in turns."""
        plain, sheathed, *unsensed = step_times([run for run in self if run], rounds).T
        return ModelCost(
            cost=StepCost(sheathed, plain),
            unsensed=StepCost(unsensed[0], plain) if unsensed else None,
            sheaths=len(sheaths(self.sheathed.model)),
            memory=memory_of(self.sheathed.model),
            reference_memory=memory_of(self.plain.model),
        )


def bench_runs(bench: Bench) -> PreparedModel:
    """The bench while its reel goes to and fro, so that the tendon slides."""
    wave = _TRAVEL * np.sin(np.linspace(0.0, 4.0 * np.pi, _BENCH_STEPS))
    specs = (mujoco_tendon_bench(bench), without_tension_sensors(build_bench(bench)))
    return PreparedModel(*(run_along(spec, wave) for spec in specs))


def finger_runs(finger: Finger) -> PreparedModel:
    """The finger in three taps."""
    runs = []
    for spec in (mujoco_tendon_finger(finger), without_tension_sensors(build_finger(finger))):
        prepared, controls = prepare_finger(tap(), spec.compile(), finger)
        runs.append(TimedRun(prepared.model, prepared.data, controls))
    return PreparedModel(*runs)


def prepare_model(name: str, steps: int = _STEPS) -> PreparedModel:
    """Drive an MJCF file so many steps, with friction and without.

    Every tendon of a file without sheaths is given friction; any other file runs as it is, and with
    its sheaths removed.
    """
    path = model_path(name)

    def run(change: Callable[[mujoco.MjSpec], object], controls: FloatArray | None) -> TimedRun:
        spec = load_spec(str(path))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", TendonWarning)  # of tendons that are left out
                change(spec)
            model = spec.compile()
        except ValueError as error:  # MuJoCo's, and those of a model that cannot have friction
            raise TendonError(f"{path}: {error}") from error
        if model.nu == 0:
            raise InvalidValueError(f"{path}: it has no actuator, so that nothing would move")
        wave = smooth_controls(model, steps) if controls is None else controls
        made = TimedRun(model, mujoco.MjData(model), wave)
        with suppress_mujoco_log():
            made.from_now()()
        if made.data.warning.number.any() or not np.isfinite(made.data.qpos).all():
            kind = "with friction" if sheaths(model) else "without friction"
            raise TendonError(
                f"{path}: the simulation became unstable, {kind}, within {steps} steps of "
                f"{model.opt.timestep:g} s"
            )
        return made

    def add(*sensors: str) -> Callable[[mujoco.MjSpec], object]:
        return lambda spec: add_friction(spec, "*", friction=FRICTION, sensors=sensors)

    own = run(lambda spec: None, None)
    if not sheaths(own.model):
        both = add("input_tension", "output_tension"), add()
        return PreparedModel(own, *(run(change, own.controls) for change in both))
    plain = run(lambda spec: remove_friction(spec, "*"), own.controls)
    return PreparedModel(plain, own, run(without_tension_sensors, own.controls))


def measure_models(
    models: Sequence[str] = (), *, rounds: int = 15, progress: Progress = silent
) -> dict[str, ModelCost]:
    """Cost of the package's bench, its tapping finger, and MJCF files with friction, by name."""
    if rounds < 1:
        raise InvalidValueError(f"rounds = {rounds} must be 1 or more")
    prepared = [prepare_model(name) for name in models]
    names = ["bench", "finger", *(model_path(name).stem for name in models)]
    for name, count in Counter(names).items():
        if count > 1:
            raise InvalidValueError(
                f"{count} models are called {name!r}: result.json goes by the names of the files"
            )
    costs = dict[str, ModelCost]()
    every = [bench_runs(Bench()), finger_runs(Finger()), *prepared]
    for name, runs in counted(progress, "models", list(zip(names, every, strict=True))):
        costs[name] = runs.cost(rounds)
    return costs


def mujoco_tendon_bench(bench: Bench) -> mujoco.MjSpec:
    """The bench without the plugin; its reel and its tension sensors go."""
    spec = build_bench(bench)
    _replace_sheaths(spec, {"tendon": bench.length}, bench.axial_stiffness, bench.pretension)
    return spec


def mujoco_tendon_finger(finger: Finger) -> mujoco.MjSpec:
    """The finger without the plugin; its tension sensors go.

    A tendon of MuJoCo knows no spool, so its first site rides on a slide with the spool's inertia,
    damping and servo, all carried over by its radius: ξ = r θ.
    """
    spec = build_finger(finger)
    lengths = dict(zip(TENDONS, spec.compile().tendon_length0, strict=True))
    _replace_sheaths(spec, lengths, finger.axial_stiffness, finger.pretension)
    r = finger.spool_radius
    for name in TENDONS:
        body, joint = spec.body(f"{name}_motor"), spec.joint(f"{name}_motor")
        body.mass = 1e-9  # a spool's does not move
        body.inertia = np.full(3, 1e-12)
        joint.type, joint.axis = mujoco.mjtJoint.mjJNT_SLIDE, [-1.0, 0.0, 0.0]
        joint.armature, joint.damping[0] = joint.armature / r**2, joint.damping[0] / r**2
        site = spec.site(f"{name}_sheath_0")
        place = np.array(site.pos) - np.array(body.pos)
        spec.delete(site)
        body.add_site(name=f"{name}_sheath_0", pos=place)
        servo = spec.actuator(f"{name}_angle")
        servo.gainprm[0] /= r
        servo.biasprm[:3] = np.array(servo.biasprm[:3]) / [r, r**2, r**2]
        servo.forcerange = np.array(servo.forcerange) / r
        spec.actuator(f"{name}_torque").gear[0] = finger.gear / r
    return spec


def without_tension_sensors(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A model with sheaths, less the sensors that one with MuJoCo's own tendons cannot have.

    A sensor that is the sheath's own instance stays: MuJoCo would delete the sheath with it.
    """
    views = {plugin.name for plugin in spec.plugins if "sensor" in plugin.config}
    for sensor in [s for s in spec.sensors if s.plugin.name in views]:
        spec.delete(sensor)
    # a deleted sensor may take its instance along, so the list is read again
    for view in [p for p in spec.plugins if "sensor" in p.config]:
        spec.delete(view)
    return spec


def _replace_sheaths(
    spec: mujoco.MjSpec, lengths: Mapping[str, float], axial_stiffness: float, pretension: float
) -> None:
    """Take the plugin out of a model, and give each tendon the stiffness that its sheath gave it.

    ``lengths`` are of the tendons at the pretension [m].
    """
    for element in [e for e in (*spec.actuators, *spec.sensors) if e.plugin.active]:
        spec.delete(element)
    for plugin in list(spec.plugins):
        spec.delete(plugin)
    for name, length in lengths.items():
        unstretched = length / (1.0 + pretension / axial_stiffness)
        tendon = spec.tendon(name)
        tendon.stiffness[0] = axial_stiffness / unstretched
        tendon.springlength = [0.0, unstretched]
