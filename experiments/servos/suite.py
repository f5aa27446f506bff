"""Joints that a servo turns by cables, with models of which one number is wrong; diagnoses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import tendon_mj
from experiments.rig_cases import Case, diagnose_case
from experiments.servos.simulation import Servo, simulate
from tendon_mj.lab.diagnosis import Diagnosis, identify
from tendon_mj.lab.recordings import read_recording
from tendon_mj.typing import FloatArray

_PERIOD = 0.02  # [s]
_SENSORS = {"motor_deg": "motor_angle", "motor_Nm": "motor_torque", "joint_deg": "joint_angle"}
_STEPS = {"motor_deg": 360 / 4096, "motor_Nm": 0.0027 * 1.8, "joint_deg": 360 / 4096}
_NOISE = {"motor_deg": 0.03, "motor_Nm": 0.01, "joint_deg": 0.05}
COLUMNS = {
    "all": ("motor_deg", "motor_Nm", "joint_deg"),
    "current": ("motor_deg", "motor_Nm"),
    "position": ("motor_deg",),
}
# hidden → the effect that names it, and its place
EFFECTS = {
    "servo": ("kp", "servo"),
    "gear": ("gear_friction", "joint_gear_sheath"),
    "motor_constant": ("sensor_gain", "motor_torque"),
    "armature": ("armature", "joint_motor"),
    "play": ("drum_play", "joint_motor"),
    "sheath": ("friction", "joint_cable_back_sheath, joint_cable_sheath"),
    "nothing": None,
}


def _write_model(path: Path, rig: Servo) -> None:
    """Write the model that a user would make of a rig with these numbers."""
    spec = mujoco.MjSpec()
    spec.modelname = "joint"
    spec.compiler.degree = False
    spec.option.timestep = 0.001
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    link = spec.worldbody.add_body(name="link")
    link.explicitinertial = True
    about_centre = rig.inertia - rig.mass * rig.centre_of_mass**2
    link.mass, link.inertia, link.ipos = rig.mass, [about_centre] * 3, [0, 0, -rig.centre_of_mass]
    link.add_joint(name="joint", axis=[0, 1, 0], damping=[rig.damping, 0, 0])
    servo = spec.add_actuator(name="servo", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="joint")
    servo.set_to_position(kp=rig.kp, kv=rig.kv)
    tendon_mj.add_cable_drive(
        spec,
        "servo",
        radius=rig.radius,
        bend=rig.bend,
        friction=rig.friction,
        pretension=rig.pretension,
        efficiency=rig.efficiency,
        motor=True,
        axial_stiffness=rig.axial_stiffness,
        length=rig.length,
        armature=rig.armature,
    )
    joint_position, force = mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtSensor.mjSENS_ACTUATORFRC
    joint, actuator = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_ACTUATOR
    spec.add_sensor(name="motor_angle", type=joint_position, objtype=joint, objname="joint_motor")
    spec.add_sensor(name="motor_torque", type=force, objtype=actuator, objname="servo")
    spec.add_sensor(name="joint_angle", type=joint_position, objtype=joint, objname="joint")
    path.write_text(spec.to_xml(), encoding="utf-8")


def _description(rig: Servo, columns: Sequence[str]) -> str:
    noise = {c: np.hypot(_NOISE[c], _STEPS[c] / np.sqrt(12.0)) for c in columns}
    measured = "\n".join(
        f'{c} = {{ sensor = "{_SENSORS[c]}", noise = {noise[c]:.3g} }}' for c in columns
    )
    tight = rig.pretension
    pretension = f"{{ value = {tight}, low = {0.9 * tight:.2f}, high = {1.1 * tight:.2f} }}"
    return f"""model = "joint.xml"
source = "experiments.servos, simulated"

[drive]
goal_deg = "servo"

[measured]
{measured}

[known]
"servo.command_scale" = 1.0
"*_sheath.drawn_bend" = 0.0
"joint_cable*_sheath.axial_stiffness" = {rig.axial_stiffness}
"joint.damping" = {rig.damping}
"link.mass" = {rig.mass}
"gravity.x" = 0.0
"gravity.y" = 0.0
"gravity.z" = -9.81

[uncertain]
"joint_cable*_sheath.pretension" = {pretension}
"""


def _motion(rng: np.random.Generator, seconds: float) -> FloatArray:
    """Goals [rad]: moves between drawn angles, smooth, fast and slow, with rests."""
    t = np.arange(0.0, seconds, _PERIOD)
    goal, here, begin = np.zeros(len(t)), 0.0, 0.5
    while begin < seconds:
        there, lasts = np.radians(rng.uniform(-50, 50)), np.exp(rng.uniform(np.log(0.3), np.log(2)))
        share = np.clip((t - begin) / lasts, 0.0, 1.0)
        goal[t >= begin] = (
            here + (there - here) * (10 * share**3 - 15 * share**4 + 6 * share**5)[t >= begin]
        )
        here, begin = there, begin + lasts + rng.choice([0.0, rng.uniform(0.1, 0.6)])
    return goal


def _draw(rng: np.random.Generator) -> Servo:
    mass, centre = rng.uniform(0.05, 0.25), rng.uniform(0.05, 0.12)
    numbers = {
        "kp": rng.uniform(2, 5),
        "kv": rng.uniform(0.08, 0.2),
        "efficiency": rng.uniform(0.75, 0.92),
        "armature": rng.uniform(0.001, 0.004),
        "friction": rng.uniform(0.06, 0.16),
        "bend": rng.uniform(1.5, 4.0),
        "length": rng.uniform(0.3, 0.8),
        "axial_stiffness": np.exp(rng.uniform(np.log(4e3), np.log(15e3))),
        "pretension": rng.uniform(15, 35),
        "radius": rng.uniform(0.008, 0.016),
        "mass": mass,
        "centre_of_mass": centre,
        "inertia": 1.3 * mass * centre**2,
        "damping": rng.uniform(0.003, 0.02),
    }
    return Servo(**{name: float(f"{value:.4g}") for name, value in numbers.items()})


def _hide(rng: np.random.Generator, believed: Servo, hidden: str) -> tuple[Servo, float]:
    """The rig as it is, and the scale of its reading of the torque."""
    up, scale = bool(rng.random() < 0.5), 1.0
    rig = believed
    if hidden == "servo":
        rig = rig._replace(kp=rig.kp * (rng.uniform(1.25, 1.6) if up else rng.uniform(0.6, 0.8)))
    elif hidden == "gear":
        rig = rig._replace(efficiency=rig.efficiency - rng.uniform(0.08, 0.2))
    elif hidden == "motor_constant":
        scale = rng.uniform(1.15, 1.4) if up else rng.uniform(0.7, 0.87)
    elif hidden == "armature":
        rig = rig._replace(armature=rig.armature * rng.uniform(1.7, 3.0))
    elif hidden == "play":
        rig = rig._replace(play=np.exp(rng.uniform(np.log(0.15e-3), np.log(1.5e-3))))
    elif hidden == "sheath":
        rig = rig._replace(
            friction=rig.friction * (rng.uniform(1.4, 2.2) if up else rng.uniform(0.4, 0.7))
        )
    return rig, scale


def _strength(hidden: str, believed: Servo, rig: Servo, scale: float) -> float:
    """Change of the first parameter of the effect that is hidden [its unit]."""
    return {
        "servo": rig.kp - believed.kp,
        "gear": 1.0 / rig.efficiency - 1.0 / believed.efficiency,
        "motor_constant": scale - 1.0,
        "armature": rig.armature - believed.armature,
        "play": rig.play / rig.radius,
        "sheath": rig.friction - believed.friction,
        "nothing": 0.0,
    }[hidden]


def make_case(folder: Path, seed: int, signals: str) -> dict[str, Any]:
    """Write a rig's model, description and two recordings; return what is hidden in it."""
    rng = np.random.default_rng(seed)
    hidden, columns = list(EFFECTS)[seed % len(EFFECTS)], COLUMNS[signals]
    while True:  # until no cable goes slack
        believed = _draw(rng)
        rig, scale = _hide(rng, believed, hidden)
        rig = rig._replace(pretension=rig.pretension * rng.uniform(0.94, 1.06))
        goals = {name: _motion(rng, 20.0) for name in ("train", "hold")}
        motions = {name: simulate(rig, goal, _PERIOD) for name, goal in goals.items()}
        if all(np.isfinite(motion).all() for motion in motions.values()):
            break
    folder.mkdir(parents=True, exist_ok=True)
    _write_model(folder / "joint.xml", believed)
    (folder / "joint.toml").write_text(_description(believed, columns), encoding="utf-8")
    for name, goal in goals.items():
        motor, torque, joint = motions[name].T
        values = {
            "motor_deg": np.degrees(motor),
            "motor_Nm": torque * scale,
            "joint_deg": np.degrees(joint),
        }
        table = [np.arange(len(goal)) * _PERIOD, np.degrees(goal)]
        for c in columns:
            read = values[c] + rng.normal(0.0, _NOISE[c], len(goal))
            table.append(np.round(read / _STEPS[c]) * _STEPS[c])
        path = folder / f"{name}.csv"
        header = ",".join(["time_s", "goal_deg", *columns])
        np.savetxt(path, np.transpose(table), "%.6g", ",", header=header, comments="")
    strength = _strength(hidden, believed, rig, scale)
    known = {"folder": folder.name, "hidden": hidden, "strength": strength, "scale": scale}
    return {**known, **rig._asdict()}


def _tellable(folder: Path, truth: dict[str, Any]) -> bool:
    """Whether `identify` says that columns and motion name what is hidden, at its strength."""
    said = identify([read_recording(folder / "train.csv", folder / "joint.toml")])
    hidden = EFFECTS[truth["hidden"]]
    named = [e.named for e in said.effects if (e.identifier, e.where) == hidden]
    return any(least is not None and abs(truth["strength"]) >= abs(least) for least in named)


def _found(diagnosis: Diagnosis) -> dict[str, Any]:
    found = diagnosis.parameters.items()
    return {"parameters": {name: [v.value, v.low, v.high] for name, v in found}}


def run_cases(
    out: Path, seeds: Iterable[int], signals: str, *, foretell: bool = False
) -> Iterator[Case]:
    """Make and diagnose each case; yield what was hidden and what was found.

    With ``foretell`` also whether `identify` calls it tellable, before.
    """
    for seed in seeds:
        folder = out / f"{signals}_{seed}"
        truth = make_case(folder, seed, signals)
        truth["tellable"] = _tellable(folder, truth) if foretell else None
        yield diagnose_case(folder / "joint.toml", truth, _found)


def summary(cases: Sequence[Case]) -> str:
    """What was named of what was hidden, in a line for each."""
    lines = list[str]()
    for hidden, effect in EFFECTS.items():
        some = [case for case in cases if case["hidden"] == hidden]
        name = effect[0] if effect else None
        first = [case for case in some if (case["effects"] or [None])[0] == name]
        wrong = [found for case in some for found in case["effects"] if found != name]
        verdicts = ", ".join(case["verdict"] for case in some)
        told = [case for case in some if case.get("tellable")]
        foretold = f"; of {len(told)} tellable {sum(c in first for c in told)}" if told else ""
        right = f"{len(first)} of {len(some)} right{foretold}"
        lines.append(f"{hidden}: {right}; wrong names {wrong}; {verdicts}")
    return "\n".join(lines)
