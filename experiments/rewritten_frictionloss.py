"""MuJoCo's `frictionloss`, rewritten in every step by the capstan equation, beside a sheath.

`python -m experiments.rewritten_frictionloss --out out/rewritten_frictionloss`. A loop in Python
sets the friction of each tendon from its input tension and the bend φ of its whole path:
T_in (1 − e^{−μφ}) while it is drawn in, T_in (e^{μφ} − 1) while it is pulled out. Compared are one
joint, an elastic cable on the bench, a hand of several joints on each tendon, and the cost of a
step. That is for tendons without pulleys that a motor, a servo or a linear spring pulls.
"""

from __future__ import annotations

import math
import os
import sys
import warnings
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from experiments.benchmarks.frictionloss import STIFF_SOLIMP, STIFF_SOLREF_STEPS
from experiments.command import run_experiment
from tendon_mj.attach import add_friction
from tendon_mj.cli import Output, console
from tendon_mj.errors import TendonWarning
from tendon_mj.lab.step_cost import (
    Quartiles,
    mujoco_tendon_bench,
    processor_time,
    smooth_controls,
    times_in_turns,
)
from tendon_mj.models import Bench, build_bench
from tendon_mj.theory import frictionloss
from tendon_mj.typing import FloatArray

Step = Callable[[mujoco.MjData], None]

FRICTION = 0.2  # μ of one joint and of the hand
DURATION = 10.0  # of a motion [s]
START = 1.0  # of the hand, in which it goes from `qpos0` to its controls; not compared [s]
SEEDS = 3  # of the controls of the hand
AMPLITUDES = (0.5, 1.0)  # of the controls of the hand, over half their range
OTHER_FRICTION = 1.001 * FRICTION  # how sensitive a motion is
HAND_ITERATIONS, HAND_LINE_SEARCHES = 100, 50  # of the solver; the file's 5 and 8 do not converge
_TRAVEL, _PERIOD = 2e-3, 8.0  # of the bench's reel [m], [s]
_FITTED = (0.3, 0.8)  # part of a stroke in which all of the tendon slides
_TINY = 1e-9  # frictionloss of a tendon without tension, for which a row is kept [N]
_JOINT = """<mujoco><option timestep="{step}" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody><site name="motor" pos="-.2 0 -.03"/><site name="guide" pos="-.05 0 .06"/>
    <body><joint name="joint" axis="0 1 0" stiffness="2" damping=".05"/>
      <geom type="capsule" fromto="0 0 0 .1 0 0" size=".01" mass=".1"/>
      <site name="end" pos=".05 0 .02"/></body></worldbody>
  <tendon><spatial name="tendon"><site site="motor"/><site site="guide"/><site site="end"/>
    </spatial></tendon>
  <actuator><motor tendon="tendon" gear="-1" ctrlrange="2 30"/></actuator></mujoco>"""


class Rewriter:
    """A step of a model whose `tendon_frictionloss` is written before it.

    Tension, bend and direction are those that MuJoCo computed in the step before, as loops of this
    kind have them.

    Args:
        model: whose tendons get friction; its `tendon_frictionloss` is changed.
        friction: μ of all tendons.
        fresh: computes tension, bend and direction for the present state and controls, which
            evaluates the model a second time.
        stiff: makes the constraints as stiff as MuJoCo takes.
    """

    def __init__(
        self, model: mujoco.MjModel, friction: float, *, fresh: bool = False, stiff: bool = True
    ) -> None:
        self.model, self.friction, self.fresh = model, friction, fresh
        on_tendon = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON.value
        self._actuators = np.flatnonzero(on_tendon)
        self._pulled = model.actuator_trnid[self._actuators, 0]
        self._gear = model.actuator_gear[self._actuators, 0]
        model.tendon_frictionloss[:] = _TINY
        if stiff:
            model.tendon_solref_fri[:] = [STIFF_SOLREF_STEPS * model.opt.timestep, 1.0]
            model.tendon_solimp_fri[:] = STIFF_SOLIMP

    def __call__(self, data: mujoco.MjData) -> None:
        """Write `tendon_frictionloss`, and step."""
        if self.fresh:
            mujoco.mj_fwdPosition(self.model, data)
            mujoco.mj_fwdVelocity(self.model, data)
            mujoco.mj_fwdActuation(self.model, data)
        self.model.tendon_frictionloss[:] = _TINY + self.losses(data)
        mujoco.mj_step(self.model, data)

    def losses(self, data: mujoco.MjData) -> FloatArray:
        """(ntendon,) T_in (1 − e^{−μφ}), or T_in (e^{μφ} − 1) where it is pulled out [N]."""
        model = self.model
        tension = model.tendon_stiffness * (data.ten_length - model.tendon_lengthspring[:, 1])
        np.subtract.at(tension, self._pulled, self._gear * data.actuator_force[self._actuators])
        return np.asarray(
            frictionloss(tension, bends(model, data), self.friction, data.ten_velocity)
        )


def bends(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """(ntendon,) total angle that each path turns through, half a turn a geom at most [rad]."""
    tendon = np.repeat(np.arange(model.ntendon), data.ten_wrapnum)
    points = data.wrap_xpos.reshape(-1, 3)[: len(tendon)]
    geom = data.wrap_obj.ravel()[: len(tendon)]
    spans = np.diff(points, axis=0)
    lengths = np.sqrt((spans * spans).sum(axis=1))
    on_geom = (geom[1:] >= 0) & (geom[1:] == geom[:-1])  # chord between its tangent points
    straight = (tendon[1:] == tendon[:-1]) & ~on_geom & (lengths > 0.0)
    along, tendon = spans[straight] / lengths[straight, None], tendon[1:][straight]
    chords = [
        np.sqrt((c * c).sum(axis=1)) for c in (along[1:] - along[:-1], along[1:] + along[:-1])
    ]
    angles = 2.0 * np.arctan2(*chords) * (tendon[1:] == tendon[:-1])
    return np.bincount(tendon[1:], angles, model.ntendon).astype(np.float64, copy=False)


def constant_bend(model: mujoco.MjModel, exponent: float) -> Step:
    """A step of a model of one tendon that a motor pulls, with a constant μφ: the least work.

    The motor's control is T_in [N].
    """
    model.tendon_frictionloss[:] = _TINY
    drawn_in, pulled_out = -math.expm1(-exponent), math.expm1(exponent)

    def step(data: mujoco.MjData) -> None:
        share = pulled_out if data.ten_velocity[0] > 0.0 else drawn_in
        model.tendon_frictionloss[0] = _TINY + data.ctrl[0] * share
        mujoco.mj_step(model, data)

    return step


def plain(model: mujoco.MjModel) -> Step:
    """A step of a model as it is."""
    return partial(mujoco.mj_step, model)


def run(step: Step, model: mujoco.MjModel, controls: FloatArray) -> FloatArray:
    """(steps, nq) positions along (steps, nu) controls from the start."""
    data = mujoco.MjData(model)
    positions = np.empty((len(controls), model.nq))
    for row, control in zip(positions, controls, strict=True):
        data.ctrl[:] = control
        step(data)
        row[:] = data.qpos
    return positions


@dataclass(frozen=True)
class Difference:
    """Difference of joint angles from those with sheaths [deg]."""

    rms: float
    largest: float

    @classmethod
    def of(cls, positions: FloatArray, sheathed: FloatArray) -> Difference:
        """Of (steps, joints) angles [rad]."""
        off = np.degrees(positions - sheathed)
        return cls(float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()))


def joint_spec(timestep: float = 1e-3) -> mujoco.MjSpec:
    """A hinge with a spring, pulled by a motor over one guide; control T_in [N]."""
    return mujoco.MjSpec.from_string(_JOINT.format(step=timestep))


def hand_spec(path: Path) -> mujoco.MjSpec:
    """The hand as published, its solver with enough iterations for friction to converge."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.option.iterations, spec.option.ls_iterations = HAND_ITERATIONS, HAND_LINE_SEARCHES
    return spec


@dataclass(frozen=True)
class Motion:
    """One motion of a model with sheaths, without friction, and with frictionloss.

    Attributes:
        travel: largest range of a joint with sheaths [deg].
        differences: variant → difference from the motion with sheaths.
    """

    travel: float
    differences: dict[str, Difference]


def compare_motion(
    build: Callable[[], mujoco.MjSpec],
    *,
    duration: float = DURATION,
    skip: float = 0.0,
    seed: int = 0,
    amplitude: float = 1.0,
) -> Motion:
    """Move a model along smooth controls with sheaths on all tendons that are pulled, and without.

    Args:
        build: makes the model without friction.
        duration: of the motion [s].
        skip: at the start, not compared [s].
        seed, amplitude: of the controls, see `smooth_controls`.
    """
    model, sheathed = build().compile(), _sheathed(build)
    timestep = model.opt.timestep
    controls = smooth_controls(model, round(duration / timestep), seed, amplitude)
    first = round(skip / timestep)
    reference = run(plain(sheathed), sheathed, controls)[first:]
    other = _sheathed(build, OTHER_FRICTION)
    variants: dict[str, tuple[Step, mujoco.MjModel]] = {
        "sheaths, μ 0.1 % larger": (plain(other), other),
        "without friction": (plain(model), model),
    }
    for name, fresh, stiff in (
        ("from the step before", False, True),
        ("from the present state", True, True),
        ("default solver settings", True, False),
    ):
        step = Rewriter(build().compile(), FRICTION, fresh=fresh, stiff=stiff)
        variants[name] = step, step.model
    return Motion(
        travel=float(np.degrees(np.ptp(reference, axis=0).max())),
        differences={
            name: Difference.of(run(*variant, controls)[first:], reference)
            for name, variant in variants.items()
        },
    )


def _sheathed(build: Callable[[], mujoco.MjSpec], friction: float = FRICTION) -> mujoco.MjModel:
    with warnings.catch_warnings():  # of tendons that nothing pulls, and of servos that can push
        warnings.simplefilter("ignore", TendonWarning)
        return add_friction(build(), "*", friction=friction, sensors=()).compile()


@dataclass(frozen=True)
class Stroke:
    """A stroke of the reel after a reversal.

    Attributes:
        stiffness: K_ap, change of T_out per elongation while all of the tendon slides [N/m].
        held: T_out at the reversal [N].
        lost: travel of the reel before T_out changes [m].
    """

    stiffness: float
    held: float
    lost: float


@dataclass(frozen=True)
class Cable:
    """The bench's elastic cable, wound in and paid out slowly."""

    winding: Stroke
    paying_out: Stroke


def cable_strokes(bench: Bench, *, rewritten: bool) -> Cable:
    """K_ap and lost motion of the bench with a sheath, or with a rewritten frictionloss.

    With frictionloss the reel is a servo of the cable's stiffness, whose control is the
    unstretched length.
    """
    wave = _TRAVEL * np.sin(2.0 * np.pi * np.arange(0.0, 1.5, bench.timestep / _PERIOD))
    if rewritten:
        spec = mujoco_tendon_bench(bench)
        stiffness = bench.axial_stiffness / bench.length
        spec.tendon("tendon").stiffness[0] = 0.0
        servo = spec.add_actuator(name="reel", trntype=mujoco.mjtTrn.mjTRN_TENDON, target="tendon")
        servo.set_to_position(kp=stiffness)
        model = spec.compile()
        length = (
            float(model.tendon_length0[model.tendon("tendon").id]) - bench.pretension / stiffness
        )
        step: Step = Rewriter(model, bench.friction)
        controls = length - wave
    else:
        model = build_bench(bench).compile()
        step, controls = plain(model), wave
    output = run(step, model, controls[:, None]).sum(axis=1)  # both slides
    tension = bench.pretension + bench.output_stiffness * output
    quarter = len(wave) // 6
    strokes = (slice(quarter, 3 * quarter), slice(3 * quarter, 5 * quarter))
    paying_out, winding = (_stroke(wave[s], output[s], tension[s]) for s in strokes)
    return Cable(winding, paying_out)


def _stroke(wound: FloatArray, output: FloatArray, tension: FloatArray) -> Stroke:
    part = (wound - wound[0]) / (wound[-1] - wound[0])
    slides = (part > _FITTED[0]) & (part < _FITTED[1])
    stiffness = np.polyfit((wound - output)[slides], tension[slides], 1)[0]
    slope, level = np.polyfit(wound[slides], tension[slides], 1)
    lost = abs((tension[0] - level) / slope - wound[0])
    return Stroke(float(stiffness), float(tension[0]), float(lost))


@dataclass(frozen=True)
class LoopCost:
    """Cost of a step in a loop in Python.

    Attributes:
        stock: time of a step of the model without friction [s].
        ratios: variant → its time over that of stock in the same round [-].
    """

    stock: Quartiles
    ratios: dict[str, Quartiles]


def loop_cost(
    build: Callable[[], mujoco.MjSpec],
    *,
    rounds: int,
    steps: int = 500,
    exponent: float | None = None,
) -> LoopCost:
    """Time a model without friction, with a rewritten frictionloss, and with sheaths, in turns.

    Args:
        build: makes the model without friction.
        rounds: each of which times all variants.
        steps: of a round and variant.
        exponent: μφ of `constant_bend`, which is left out by default.
    """
    sheathed, stock = _sheathed(build), build().compile()
    late, fresh = (Rewriter(build().compile(), FRICTION, fresh=fresh) for fresh in (False, True))
    controls = smooth_controls(stock, steps)
    loops: dict[str, tuple[Step, mujoco.MjModel]] = {
        "from the step before": (late, late.model),
        "from the present state": (fresh, fresh.model),
        "sheaths": (plain(sheathed), sheathed),
    }
    if exponent is not None:
        model = build().compile()
        loops["constant bend"] = constant_bend(model, exponent), model
    tasks = [
        partial(run, step, model, controls)
        for step, model in ((plain(stock), stock), *loops.values())
    ]
    spent = times_in_turns(tasks, rounds, processor_time).T / steps
    ratios = {name: Quartiles.of(t / spent[0]) for name, t in zip(loops, spent[1:], strict=True)}
    return LoopCost(Quartiles.of(spent[0]), ratios)


def rewritten_frictionloss(
    out: Path = Path("out/rewritten_frictionloss"), hand: Path | None = None, rounds: int = 15
) -> None:
    """Compare a frictionloss that is rewritten in every step with sheaths: motion and cost.

    Takes a quarter of a minute.

    Args:
        out: folder for result.json.
        hand: MJCF of the Aero hand; by default aero_hand.xml in the folder that TENDON_MJ_MODELS
            names, and no hand where it names none.
        rounds: of every timing; each round times all variants, in turns.
    """
    output = Output(out)
    folder = os.environ.get("TENDON_MJ_MODELS")
    if hand is None and folder:
        hand = Path(folder) / "aero_hand.xml"
    builds: dict[str, Callable[[], mujoco.MjSpec]] = {"joint": joint_spec}
    motions = {"joint": compare_motion(joint_spec)}
    if hand is not None:
        builds["hand"] = partial(hand_spec, hand)
        for amplitude in AMPLITUDES:
            for seed in range(SEEDS):
                motions[f"hand, amplitude {amplitude:g}, seed {seed}"] = compare_motion(
                    builds["hand"], skip=START, seed=seed, amplitude=amplitude
                )
    cables = {
        name: cable_strokes(Bench(), rewritten=rewritten)
        for name, rewritten in (("sheath", False), ("rewritten", True))
    }
    costs = {
        name: loop_cost(build, rounds=rounds, exponent=FRICTION if name == "joint" else None)
        for name, build in builds.items()
    }
    results: dict[str, Mapping[str, Motion | Cable | LoopCost]] = {
        "motion_deg": motions,
        "cable_N_m": cables,
        "cost_s": costs,
    }
    output.result(
        {
            name: {part: asdict(value) for part, value in group.items()}
            for name, group in results.items()
        }
    )
    for line in summary(motions, cables, costs):
        console.print(line, soft_wrap=True)
    output.close()


def summary(
    motions: dict[str, Motion], cables: dict[str, Cable], costs: dict[str, LoopCost]
) -> list[str]:
    """The results in a few lines."""
    lines = []
    for model, motion in motions.items():
        lines.append(f"{model}: travel {motion.travel:.1f}°; off the sheaths, rms and at most:")
        lines += [
            f"  {name}: {off.rms:.3g}°, {off.largest:.3g}°"
            for name, off in motion.differences.items()
        ]
    for name, cable in cables.items():
        parts = [
            f"{way} K_ap = {1e-3 * stroke.stiffness:.1f} N/mm, "
            f"{1e3 * stroke.lost:.3f} mm lost at {stroke.held:.1f} N"
            for way, stroke in (("winding", cable.winding), ("paying out", cable.paying_out))
        ]
        lines.append(f"cable, {name}: {'; '.join(parts)}")
    for model, cost in costs.items():
        ratios = "; ".join(
            f"{name} {ratio.median:.2f} ({ratio.low:.2f} … {ratio.high:.2f})"
            for name, ratio in cost.ratios.items()
        )
        lines.append(f"{model}: a step takes {1e6 * cost.stock.median:.1f} µs; times {ratios}")
    return lines


if __name__ == "__main__":
    sys.exit(run_experiment(rewritten_frictionloss, "rewritten_frictionloss"))
