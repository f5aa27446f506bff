"""What four sets of columns tell of a rig with a motor, and whether `identify` is right.

`python -m experiments.signals --draws 10 --out out/signals`. The rig is that of docs/your_rig.md
with a servo on the spool, which logs its position and its torque (current times torque constant);
an encoder on the lever or a load cell at the output is added. After the four sets are identified,
effects that are called named are drawn, with a set each: a rehearsal at twice the stated strength
is diagnosed. Of pairs that are called not told apart, drawn likewise, the first effect is rehearsed
at twice the strength from which it is noticed, and only the second is offered to the diagnosis: the
rms error that it leaves is stated, in noises.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

import tendon_mj
from experiments.command import run_experiment
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Identifiability,
    Tellable,
    diagnose,
    identify,
    rehearse,
)
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import FloatArray

SETS: Mapping[str, tuple[str, ...]] = {
    "position": ("spool_rad",),
    "position and current": ("spool_rad", "motor_Nm"),
    "with an encoder": ("spool_rad", "motor_Nm", "lever_rad"),
    "with a load cell": ("spool_rad", "motor_Nm", "output_N"),
}
NOISE = {"spool_rad": 5e-4, "motor_Nm": 2e-3, "lever_rad": 2.5e-3, "output_N": 0.05}
_SENSORS = dict(zip(NOISE, ("spool", "motor", "lever", "output_tension"), strict=True))
_RATE, _LONG, _STROKE = 50.0, 10.0, 1.0  # [Hz], [s], [rad]
_GAIN, _DRUM, _PULLEY, _PRETENSION, _BEND = 1.5, 0.010, 0.015, 15.0, np.pi


def write_rig(path: Path) -> Path:
    """Write the rig of docs/your_rig.md with a servo on its spool, and sensors of all columns."""
    spec = mujoco.MjSpec()
    spec.modelname = "rig_with_motor"
    spec.compiler.degree = False
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0, 0, 0]
    places = tendon_mj.arc_points(length=0.6, bend=_BEND, guides=18)
    tendon_mj.add_tendon(spec, "cable", tendon_mj.add_sites(spec, "guide", places))
    lever = spec.worldbody.add_body(name="lever", pos=places[-1] + [0, _PULLEY, 0])
    rod = mujoco.mjtGeom.mjGEOM_CAPSULE
    lever.add_geom(type=rod, fromto=[0, 0, 0, -0.12, 0, 0], size=[0.008], density=2700)
    hinge = lever.add_joint(name="lever", axis=[0, 0, 1])
    hinge.stiffness, hinge.damping = [0.3, 0, 0], [0.01, 0, 0]
    hinge.springref = -_PULLEY * _PRETENSION / 0.3
    spool = spec.worldbody.add_body(name="spool", pos=places[0] + [0, -_DRUM, 0])
    drum = mujoco.mjtGeom.mjGEOM_CYLINDER
    spool.add_geom(type=drum, size=[_DRUM, 0.004, 0], mass=0.02)
    axle = spool.add_joint(name="spool", axis=[0, 0, 1], armature=6e-5)
    axle.damping = [3e-3, 0, 0]
    motor = spec.add_actuator(name="motor", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="spool")
    motor.set_to_position(kp=_GAIN, kv=0.03)
    tendon_mj.add_friction(
        spec,
        "cable",
        name="sheath",
        friction=0.12,
        axial_stiffness=4000,
        pretension=_PRETENSION,
        reel_joint="spool",
        reel_radius=_DRUM,
        output_joint="lever",
        output_radius=-_PULLEY,
        sensors=("output_tension",),
    )
    joint, actuator = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_ACTUATOR
    for name, kind, of in (
        ("spool", mujoco.mjtSensor.mjSENS_JOINTPOS, joint),
        ("lever", mujoco.mjtSensor.mjSENS_JOINTPOS, joint),
        ("motor", mujoco.mjtSensor.mjSENS_ACTUATORFRC, actuator),
    ):
        spec.add_sensor(name=name, type=kind, objtype=of, objname=name)
    path.write_text(spec.to_xml(), encoding="utf-8")
    return path


def plan(model: Path, name: str, motion: FloatArray, columns: tuple[str, ...]) -> Recording:
    """A recording of a command to the servo, before anything was measured."""
    time = np.arange(motion.size) / _RATE
    return Recording(
        name=name,
        model=str(model),
        source="planned by experiments/signals.py",
        time=time,
        columns={"command_rad": motion} | {c: np.zeros(time.size) for c in columns},
        drive={"command_rad": "motor"},
        measured={c: Measured(_SENSORS[c], NOISE[c]) for c in columns},
        known={
            "motor.command_offset": _PRETENSION * _DRUM / _GAIN,
            "motor.kp": _GAIN,
            "motor.kv": 0.03,
            "spool.armature": 6e-5,
            "spool.damping": 3e-3,
            "sheath.axial_stiffness": 4000.0,
            "sheath.drawn_bend": _BEND,
            "lever.stiffness": 0.3,
            "lever.damping": 0.01,
        },
        uncertain={
            "sheath.friction": Uncertain(0.12, 0.03, 0.3),
            "sheath.pretension": Uncertain(_PRETENSION, 12.0, 18.0),
        },
        settle=0.0,
    )


def motions() -> dict[str, FloatArray]:
    """Growing loops with rests, and sines to be held out [rad]."""
    time = np.arange(round(_LONG * _RATE) + 1) / _RATE
    corners = [0.0, 0.0, 0.5, 0.5, 0.2, 0.2, 0.8, 0.8, 0.0, 0.0, 1.0, 1.0, 0.3, 0.3, 0.7, 0.7, 0.0]
    at = np.linspace(0.0, _LONG, len(corners))
    sines = 0.5 * (1.0 - np.cos(2.0 * np.pi * 0.4 * time)) * (0.6 + 0.4 * np.sin(0.7 * time))
    return {"loops": _STROKE * np.interp(time, at, corners), "sines": _STROKE * sines}


def study(draws: int = 10, out: Path = Path("out/signals"), seed: int = 0) -> None:
    """Identify four sets of columns, and rehearse what is called named and what not told apart.

    Args:
        draws: effects that are called named, and as many pairs that are not told apart.
        out: folder for result.json.
        seed: of the draws and of the noise.
    """
    out.mkdir(parents=True, exist_ok=True)
    model, found = write_rig(out / "rig_with_motor.xml"), dict[str, Identifiability]()
    for label, columns in SETS.items():
        loops = plan(model, "loops", motions()["loops"], tuple(NOISE))
        found[label] = identify([loops], columns)
        print(f"{label}: {found[label].sentence}", flush=True)
    random, rows = np.random.default_rng(seed), list[dict[str, object]]()
    named = [(s, e) for s, f in found.items() for e in f.effects if e.named is not None]
    for k in random.permutation(len(named))[:draws]:
        label, effect = named[k]
        rows.append(_rehearse(model, label, effect, 2.0 * (effect.named or 0.0), ()))
        rows[-1]["right"] = effect.identifier in str(rows[-1]["effects"])
        print(effect.label, rows[-1], flush=True)
    alike = [(s, f, p) for s, f in found.items() for p in f.pairs if p.below is None]
    for k in random.permutation(len(alike))[:draws]:
        label, of, pair = alike[k]
        one, other = (next(e for e in of.effects if e.label == name) for name in pair.effects)
        noticed = one.noticed or 0.0
        rows.append(
            _rehearse(model, label, one, 2.0 * noticed, (other.identifier,))
            | {"pair": pair.effects}
        )
        print(pair.effects, rows[-1], flush=True)
    result = {"sets": {label: f.result() for label, f in found.items()}, "rehearsed": rows}
    (out / "result.json").write_text(json.dumps(result, indent=2), encoding="utf-8")


def _rehearse(
    model: Path, label: str, effect: Tellable, change: float, only: tuple[str, ...]
) -> dict[str, object]:
    """Diagnosis of a rehearsal with an effect, among some effects of the catalogue or all."""
    plans = [plan(model, name, motion, SETS[label]) for name, motion in motions().items()]
    value = Simulator(plans).parameters[effect.parameter].value + change
    try:  # with its shape, if it has one place
        (train, held_out), planted = rehearse(plans, {effect.identifier: value})
    except InvalidValueError:
        (train, held_out), planted = rehearse(plans, {effect.parameter: value})
    catalogue = {name: CATALOGUE[name] for name in only or CATALOGUE}
    result = diagnose([train], [held_out], catalogue=catalogue)
    left = [result.train.after]
    if only and result.search and not result.findings:  # of the effect, which was not called one
        context, selection = result.search
        others = context.extend(selection.calibrated)
        fits = (model.fit for model in (*others.fitted, *others.at_end))
        left += [float(np.sqrt(np.mean(f.residual[context.problem.in_train] ** 2))) for f in fits]
    return {
        "set": label,
        "planted": planted,
        "verdict": result.verdict,
        "effects": [f.identifier for f in result.findings],
        "rivals": [list(f.rivals) for f in result.findings],
        "left": min(left),
    }


if __name__ == "__main__":
    sys.exit(run_experiment(study, "signals"))
