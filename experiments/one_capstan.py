"""A rig with one capstan and two cables: play, friction and pretension by three models of it.

`python -m experiments.one_capstan --seeds 10 --out out/one_capstan`. The recordings are simulated
by this module alone: each cable is a row of segments between guides, T = EA (ℓ/s − 1) of the
unstretched length s that a segment holds. A guide lets cable pass as soon as the tensions on its
sides differ by more than e^{μφ/n}; all guides are relaxed in turn until none does. The joint, with
its inertia, spring and damper, follows by backward Euler. A drum with play holds itself in the gap.
Nothing here is of the package's sheath, and noise is drawn anew for each seed.

The models differ in what the measured angle of the motor drives: two reels; the servo of a spool
joint, with an armature or with one that is too small; the spool joint itself.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import mujoco
import numpy as np
from numba import njit

import tendon_mj
from experiments.command import run_experiment
from tendon_mj.typing import FloatArray

Way = Literal["reel", "spool", "soft spool", "prescribed"]

LENGTH, BEND, AXIAL_STIFFNESS = 0.5, 2.0 * np.pi / 3.0, 4000.0  # of each cable [m], [rad], [N]
DRUM, PULLEY = 0.008, 0.012  # radii [m]
SPRING, DAMPING, INERTIA = 0.1, 0.01, 1e-4  # of the wrist [N m/rad], [N m s/rad], [kg m²]
PLAY, FRICTION, PRETENSION = 4e-4, 0.10, 8.3  # true values: [m] of cable, [-], [N]
STRETCH = 1.0 + PRETENSION / AXIAL_STIFFNESS  # of cable as drum and pulley take it up [-]
NOISE_TENSION, NOISE_ANGLE = 0.05, 0.1  # [N], [deg]
GUIDES, STEP, RATE, REST = 24, 5e-4, 50.0, 0.5  # [-], [s], samples per second, [s]
ARMATURE, SMALL_ARMATURE = 0.01, 1.5e-4  # of the motor as geared [kg m²]


class Motion(NamedTuple):
    """Time [s], motor angle [deg], and (n, 3) readings without noise."""

    name: str
    time: FloatArray
    motor: FloatArray
    readings: FloatArray


@njit(cache=False)
def _tension(length: float, held: float) -> float:
    return max(0.0, AXIAL_STIFFNESS * (length / held - 1.0))


@njit(cache=False)
def _relax(lengths: FloatArray, held: FloatArray, ratio: float) -> float:
    """Let cable pass each guide once, as far as its two tensions allow; the most that passed."""
    most = 0.0
    for i in range(lengths.size - 1):
        before, behind = _tension(lengths[i], held[i]), _tension(lengths[i + 1], held[i + 1])
        to_input = before - ratio * behind
        to_output = behind - ratio * before
        soft = AXIAL_STIFFNESS * lengths[i] / held[i] ** 2
        hard = AXIAL_STIFFNESS * lengths[i + 1] / held[i + 1] ** 2
        passed = 0.0
        if to_input > 0.0:
            passed = to_input / (soft + ratio * hard)
        elif to_output > 0.0:
            passed = -to_output / (hard + ratio * soft)
        held[i] += passed
        held[i + 1] -= passed
        most = max(most, abs(passed))
    return most


@njit(cache=False)
def _march(
    motor: FloatArray,
    every: int,
    lengths: FloatArray,
    held: FloatArray,
    ratio: float,
    play: float,
    record: FloatArray,
) -> None:
    """Follow (steps,) angles of the motor; rows of ``record``: tensions at the motor, wrist angle.

    ``held`` (2, segments): unstretched lengths of both cables, changed in place.
    """
    last = lengths.size - 1
    drum = wrist = speed = 0.0
    for k in range(motor.size):
        turned = min(max(drum, motor[k] - 0.5 * play / DRUM), motor[k] + 0.5 * play / DRUM)
        wound, drum = DRUM * (turned - drum) / STRETCH, turned
        held[0, 0] -= wound
        held[1, 0] += wound
        start = wrist
        for _ in range(20000):
            moved = max(_relax(lengths, held[0], ratio), _relax(lengths, held[1], ratio))
            rate = (wrist - start) / STEP
            pull = _tension(lengths[last], held[0, last]) - _tension(lengths[last], held[1, last])
            torque = PULLEY * pull - SPRING * wrist - DAMPING * rate
            torque -= INERTIA * (rate - speed) / STEP
            stiffness = SPRING + DAMPING / STEP + INERTIA / STEP**2
            for cable in range(2):
                stiffness += PULLEY**2 * AXIAL_STIFFNESS * lengths[last] / held[cable, last] ** 2
            turn = torque / stiffness
            wrist += turn
            held[0, last] += PULLEY * turn / STRETCH
            held[1, last] -= PULLEY * turn / STRETCH
            if max(moved, PULLEY * abs(turn)) < 1e-12:
                break
        speed = (wrist - start) / STEP
        if k % every == 0:
            record[k // every, 0] = _tension(lengths[0], held[0, 0])
            record[k // every, 1] = _tension(lengths[0], held[1, 0])
            record[k // every, 2] = wrist


def triangles() -> tuple[FloatArray, FloatArray]:
    """Time [s] and motor angle [deg]: straight lines between turning points, large and small."""
    turns, speed = np.array([0.0, 55.0, -50.0, 45.0, 5.0, 40.0, 15.0, 30.0, -40.0, 0.0]), 90.0
    corners = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)) / speed)])
    time = np.arange(0.0, REST + corners[-1], 1.0 / RATE)
    return time, np.interp(time - REST, corners, turns)


def sines() -> tuple[FloatArray, FloatArray]:
    """Time [s] and motor angle [deg]: two sines of other sizes and speeds."""
    time = np.arange(0.0, REST + 5.0, 1.0 / RATE)
    moved = np.maximum(time - REST, 0.0)
    return time, 30.0 * np.sin(2.6 * moved) + 20.0 * np.sin(6.1 * moved)


def simulate(time: FloatArray, motor: FloatArray, play: float = PLAY) -> FloatArray:
    """(n, 3) tensions of both cables at the motor [N] and angle of the wrist [deg], no noise.

    Args:
        time: (n,) samples, at `RATE` from 0 on [s].
        motor: (n,) angle of the motor, linear between samples [deg].
        play: between motor and drum, as cable [m].
    """
    lengths = np.full(GUIDES + 1, LENGTH / GUIDES)
    lengths[[0, -1]] *= 0.5
    held = np.tile(lengths / (1.0 + PRETENSION / AXIAL_STIFFNESS), (2, 1))
    every = round(1.0 / (RATE * STEP))
    fine = np.arange((time.size - 1) * every + 1) * STEP
    record = np.zeros((time.size, 3))
    ratio = math.exp(FRICTION * BEND / GUIDES)
    _march(np.radians(np.interp(fine, time, motor)), every, lengths, held, ratio, play, record)
    record[:, 2] = np.degrees(record[:, 2])
    return record


def noisy(readings: FloatArray, random: np.random.Generator) -> FloatArray:
    """Readings with the noise of the rig, (n, 3)."""
    noise = np.array([NOISE_TENSION, NOISE_TENSION, NOISE_ANGLE])
    return readings + noise * random.standard_normal(readings.shape)


def build(way: Way) -> mujoco.MjSpec:
    """Model of the rig, wound in one of the ways, with guesses for its parameters."""
    spec = mujoco.MjSpec()
    spec.modelname = "wrist"
    spec.compiler.degree = False
    spec.option.timestep = 0.001
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0, 0, 0]
    path = tendon_mj.arc_points(length=LENGTH, bend=BEND, guides=18)
    wrist = spec.worldbody.add_body(name="wrist", pos=path[-1])
    wrist.explicitinertial, wrist.mass, wrist.inertia = True, 0.05, [INERTIA] * 3
    wrist.ipos = [0, 0, 0]
    hinge = wrist.add_joint(name="wrist", axis=[0, 0, 1])
    hinge.stiffness, hinge.damping = [SPRING, 0, 0], [DAMPING, 0, 0]
    if way != "reel":
        drum = spec.worldbody.add_body(name="spool", pos=path[0])
        drum.explicitinertial, drum.mass, drum.inertia = True, 0.02, [1e-6] * 3
        drum.ipos = [0, 0, 0]
        armature = SMALL_ARMATURE if way == "soft spool" else ARMATURE
        drum.add_joint(name="spool", axis=[0, 0, 1], armature=armature)
        motor = spec.add_actuator(name="motor", target="spool", trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=4e6 * armature, kv=2e3 * armature)
    for cable, side in (("agonist", 1.0), ("antagonist", -1.0)):
        points = path + np.array([0.0, 0.0, 0.003 * side])
        tendon_mj.add_tendon(spec, cable, tendon_mj.add_sites(spec, cable, points))
        winds: dict[str, Any] = {"reel": f"{cable}_reel"}
        if way != "reel":
            winds = {"reel_joint": "spool", "reel_radius": DRUM * side}
        tendon_mj.add_friction(
            spec,
            [cable],
            friction=0.13,
            axial_stiffness=AXIAL_STIFFNESS,
            pretension=8.0,
            output_joint="wrist",
            output_radius=-PULLEY * side,
            sensors=("input_tension",),
            **winds,
        )
    spec.add_sensor(
        name="wrist_angle",
        type=mujoco.mjtSensor.mjSENS_JOINTPOS,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        objname="wrist",
    )
    return spec


def record(
    name: str, time: FloatArray, motor: FloatArray, readings: FloatArray, way: Way, model: str
) -> tendon_mj.Recording:
    """The recording of a motion, described for one of the models."""
    reels = {"reel": ("agonist_reel", "antagonist_reel"), "prescribed": ("spool",)}
    known = {
        "wrist.stiffness": SPRING,
        "wrist.damping": DAMPING,
        "*_sheath.axial_stiffness": AXIAL_STIFFNESS,
        "*_sheath.drawn_bend": BEND,
    }
    if way == "reel":
        known |= {"agonist_reel.command_scale": DRUM, "antagonist_reel.command_scale": -DRUM}
    return tendon_mj.Recording(
        name=name,
        model=model,
        source="simulated by experiments/one_capstan.py",
        time=time,
        columns={
            "motor_rad": np.radians(motor),
            "agonist_N": readings[:, 0],
            "antagonist_N": readings[:, 1],
            "wrist_rad": np.radians(readings[:, 2]),
        },
        drive={"motor_rad": reels.get(way, ("motor",))},
        measured={
            "agonist_N": tendon_mj.Measured("agonist_input_tension", NOISE_TENSION),
            "antagonist_N": tendon_mj.Measured("antagonist_input_tension", NOISE_TENSION),
            "wrist_rad": tendon_mj.Measured("wrist_angle", math.radians(NOISE_ANGLE)),
        },
        known=known,
        uncertain={
            "*_sheath.friction": tendon_mj.Uncertain(0.13, 0.03, 0.3),
            "*_sheath.pretension": tendon_mj.Uncertain(8.0, 6.0, 10.0),
        },
    )


class Estimate(NamedTuple):
    """A fitted number, its 95 % interval, and the truth."""

    value: float
    low: float
    high: float
    truth: float

    @property
    def holds(self) -> bool:
        """Whether the interval holds the truth."""
        return self.low <= self.truth <= self.high


class Outcome(NamedTuple):
    """Diagnosis of one seed by one model."""

    effects: list[str]
    estimates: dict[str, Estimate]  # play, friction, pretension
    warned: bool  # of the joint that winds


def diagnose(way: Way, model: str, motions: Sequence[Motion], seed: int) -> Outcome:
    """Diagnose the rig by one of its models: the first motion fitted, the others held out."""
    random = np.random.default_rng(seed)
    recordings = [
        record(name, time, motor, noisy(readings, random), way, model)
        for name, time, motor, readings in motions
    ]
    result = tendon_mj.diagnose(recordings[:1], recordings[1:]).result()
    fitted = {**result["parameters"], **result["calibrated"]}
    truths = {"backlash": PLAY, "friction": FRICTION, "pretension": PRETENSION}
    estimates = {}
    for name, truth in truths.items():
        value = fitted.get(f"agonist_sheath.{name}")
        if value is not None:
            estimates[name] = Estimate(value["value"], value["low"], value["high"], truth)
    return Outcome(result["effects"], estimates, "Joint 'spool'" in " ".join(result["warnings"]))


def one_capstan(
    out: Path = Path("out/one_capstan"),
    seeds: int = 10,
    ways: tuple[Way, ...] = get_args(Way),
) -> None:
    """Diagnose the rig with fresh noise, by each of its models: how often is the truth held?

    Args:
        out: folder for the models and table.md.
        seeds: noise is drawn from seeds 0 to this.
        ways: in which the model winds its cables.
    """
    out.mkdir(parents=True, exist_ok=True)
    motions = [
        Motion(motion.__name__, time, motor, simulate(time, motor))
        for motion in (triangles, sines)
        for time, motor in [motion()]
    ]
    lines = ["| model | named `backlash` | play, its interval [µm] | held: play, μ, T_0 | warned |"]
    lines.append("|---|---|---|---|---|")
    for way in ways:
        model = out.resolve() / f"{way.replace(' ', '_')}.xml"
        model.write_text(build(way).to_xml(), encoding="utf-8")
        outcomes = [diagnose(way, str(model), motions, seed) for seed in range(seeds)]
        plays = [o.estimates["backlash"] for o in outcomes if "backlash" in o.estimates]
        mean, low, high = (1e6 * np.mean([p[k] for p in plays]) for k in range(3))
        held = [
            sum(name in o.estimates and o.estimates[name].holds for o in outcomes)
            for name in ("backlash", "friction", "pretension")
        ]
        named = sum(outcome.effects == ["backlash"] for outcome in outcomes)
        warned = sum(outcome.warned for outcome in outcomes)
        numbers = f"{mean:.1f}, {low:.1f} … {high:.1f} | {', '.join(map(str, held))}"
        lines.append(f"| {way} | {named} of {seeds} | {numbers} | {warned} |")
        print(lines[-1], flush=True)
    (out / "table.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(run_experiment(one_capstan, "one_capstan"))
