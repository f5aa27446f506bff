"""Draws elbows, hides play or a soft mount in some, and diagnoses each as its user would."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import tendon_mj
from experiments.elbows.simulation import Elbow, simulate
from experiments.rig_cases import Case, diagnose_case
from tendon_mj.lab.diagnosis import Diagnosis
from tendon_mj.typing import FloatArray

_PERIOD = 0.02  # [s]
_NOISE = {"agonist_N": 0.09, "antagonist_N": 0.09, "elbow_deg": 0.1}
# kind of a rig → what is hidden in rigs of it, in turns
HIDDEN = {
    "elbow": ("drum", "output", "nothing"),
    "angle_only": ("nothing", "drum"),
    "mount": ("mount",),
}
# what is hidden → effect that is to be named, and number of the rig, which has mostly its name
_EFFECTS = {"drum": "backlash", "output": "output_play", "mount": "output_compliance"}
_NUMBERS = _EFFECTS | {"drum": "drum_play"}
_USUAL_TENSION = 40.0  # at which a mount yields by as much as a play is wide [N]


def _write_model(path: Path, rig: Elbow) -> None:
    """Write the model that a user would make of the rig, with friction 0.12 and no play."""
    spec = mujoco.MjSpec()
    spec.modelname = "elbow"
    spec.compiler.degree = False
    spec.option.timestep = 0.001
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    places = tendon_mj.arc_points(length=rig.length, bend=rig.bend, guides=18)
    arm = spec.worldbody.add_body(name="forearm", pos=places[-1])
    arm.explicitinertial = True
    about_centre = rig.inertia - rig.mass * rig.centre_of_mass**2
    arm.mass, arm.inertia, arm.ipos = rig.mass, [about_centre] * 3, [0, 0, -rig.centre_of_mass]
    arm.add_joint(name="elbow", axis=[0, 1, 0], damping=[rig.damping, 0, 0])
    for cable, side in (("agonist", 1.0), ("antagonist", -1.0)):
        sites = tendon_mj.add_sites(spec, cable, np.add(places, [0, 0, 0.003 * side]))
        tendon_mj.add_tendon(spec, cable, sites)
        tendon_mj.add_friction(
            spec,
            [cable],
            friction=0.12,
            axial_stiffness=rig.axial_stiffness,
            pretension=round(rig.pretension),
            reel=f"{cable}_reel",
            output_joint="elbow",
            output_radius=-rig.radius * side,
            sensors=("input_tension",),
        )
    spec.add_sensor(
        name="elbow_angle",
        type=mujoco.mjtSensor.mjSENS_JOINTPOS,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        objname="elbow",
    )
    path.write_text(spec.to_xml(), encoding="utf-8")


def _description(rig: Elbow, columns: list[str]) -> str:
    sensors = {
        "agonist_N": "agonist_input_tension",
        "antagonist_N": "antagonist_input_tension",
        "elbow_deg": "elbow_angle",
    }
    measured = "\n".join(
        f'{c} = {{ sensor = "{sensors[c]}", noise = {_NOISE[c]} }}' for c in columns
    )
    friction_of_joint = (
        f'"elbow.frictionloss" = {{ value = 0.1, low = 0.0, high = {4 * rig.dry_friction:.2f} }}\n'
        if rig.dry_friction
        else ""
    )
    guess = round(rig.pretension)
    return f"""model = "elbow.xml"
source = "experiments.elbows, simulated"

[drive]
motor_deg = ["agonist_reel", "antagonist_reel"]

[measured]
{measured}

[known]
"agonist_reel.command_scale" = {rig.drum_radius}
"antagonist_reel.command_scale" = {-rig.drum_radius}
"*_sheath.axial_stiffness" = {rig.axial_stiffness}
"*_sheath.drawn_bend" = {rig.bend}
"elbow.damping" = {rig.damping}
"forearm.mass" = {rig.mass}
"gravity.x" = 0.0
"gravity.y" = 0.0
"gravity.z" = -9.81

[uncertain]
"*_sheath.friction" = {{ value = 0.12, low = 0.02, high = 0.4 }}
"*_sheath.pretension" = {{ value = {guess}.0, low = {0.8 * guess:.1f}, high = {1.2 * guess:.1f} }}
{friction_of_joint}"""


def _motion(rng: np.random.Generator, seconds: float) -> FloatArray:
    """A drum's angle [rad]: triangles or a sum of two sines, out of rest."""
    t = np.arange(0.0, seconds, _PERIOD)
    stroke, rate = np.radians(rng.uniform(40, 70)), rng.uniform(0.12, 0.3)
    if rng.random() < 0.5:
        shape = 2.0 / np.pi * np.arcsin(np.sin(2 * np.pi * rate * t))
        shape *= 1.0 - 0.5 * t / seconds
    else:
        shape = 0.7 * np.sin(2 * np.pi * rate * t) + 0.3 * np.sin(2 * np.pi * 1.7 * rate * t)
    return np.asarray(stroke * shape * np.clip(t, 0.0, 1.0))


def _draw(rng: np.random.Generator, hidden: str) -> Elbow:
    mass, centre = rng.uniform(0.5, 1.6), rng.uniform(0.1, 0.18)
    radius, play = rng.uniform(0.02, 0.04), np.exp(rng.uniform(np.log(0.2e-3), np.log(3e-3)))
    rounded = {
        "friction": rng.uniform(0.06, 0.22),
        "bend": rng.uniform(1.5, 3.5),
        "length": rng.uniform(0.6, 1.2),
        "axial_stiffness": np.exp(rng.uniform(np.log(8e3), np.log(30e3))),
        "pretension": rng.uniform(25, 50),
        "radius": radius,
        "drum_radius": rng.uniform(0.015, 0.03),
        "mass": mass,
        "centre_of_mass": centre,
        "inertia": 1.3 * mass * centre**2,
        "damping": rng.uniform(0.1, 0.6),
        "dry_friction": rng.choice([0.0, rng.uniform(0.05, 0.25)]),
    }
    numbers = {k: float(f"{v:.4g}") for k, v in rounded.items()}
    numbers["drum_play"] = float(play) if hidden == "drum" else 0.0
    numbers["output_play"] = float(play / radius) if hidden == "output" else 0.0
    numbers["output_compliance"] = float(play / _USUAL_TENSION) if hidden == "mount" else 0.0
    return Elbow(**numbers)


def make_case(folder: Path, seed: int, kind: str) -> dict[str, Any]:
    """Write a rig's model, description and two recordings; return what is hidden in it."""
    rng = np.random.default_rng(seed)
    hidden = HIDDEN[kind][seed % len(HIDDEN[kind])]
    columns = ["elbow_deg"]
    if kind != "angle_only":
        columns = ["agonist_N", *(["antagonist_N"] if rng.random() < 0.5 else []), "elbow_deg"]
    while True:  # until no cable goes slack
        rig, drums = _draw(rng, hidden), {name: _motion(rng, 24.0) for name in ("train", "hold")}
        motions = {name: simulate(rig, drum, _PERIOD) for name, drum in drums.items()}
        if all(np.isfinite(motion).all() for motion in motions.values()):
            break
    folder.mkdir(parents=True, exist_ok=True)
    _write_model(folder / "elbow.xml", rig)
    (folder / "elbow.toml").write_text(_description(rig, columns), encoding="utf-8")
    for name, drum in drums.items():
        first, second, angle = motions[name].T
        values = {"agonist_N": first, "antagonist_N": second, "elbow_deg": np.degrees(angle)}
        table = [np.arange(len(drum)) * _PERIOD, np.degrees(drum)]
        table += [values[c] + rng.normal(0.0, _NOISE[c], len(drum)) for c in columns]
        header = ",".join(["time_s", "motor_deg", *columns])
        path = folder / f"{name}.csv"
        np.savetxt(path, np.transpose(table), "%.5g", ",", header=header, comments="")
    return {"folder": folder.name, "hidden": hidden, "measured": columns, **rig._asdict()}


def _found(diagnosis: Diagnosis) -> dict[str, Any]:
    numbers = {**diagnosis.calibrated, **diagnosis.parameters}
    sizes = [v for k, v in numbers.items() if k.rpartition(".")[2] in _EFFECTS.values()]
    friction = numbers["agonist_sheath.friction"]
    return {
        "friction_found": [friction.value, friction.low, friction.high],
        "size_found": [sizes[0].value, sizes[0].low, sizes[0].high] if sizes else None,
    }


def run_cases(out: Path, seeds: Iterable[int], kind: str) -> Iterator[Case]:
    """Make and diagnose each case; yield what was hidden and what was found."""
    for seed in seeds:
        folder = out / f"{kind}_{seed}"
        truth = make_case(folder, seed, kind)
        yield diagnose_case(folder / "elbow.toml", truth, _found)


def _holds(interval: list[float], truth: float) -> bool:
    return interval[1] <= truth <= interval[2]


def summary(cases: Sequence[Case]) -> str:
    """What was found of what was hidden, in a few lines."""
    lines = list[str]()
    for hidden, effect in _EFFECTS.items():
        if not (some := [case for case in cases if case["hidden"] == hidden]):
            continue
        first = [case for case in some if case["effects"][:1] == [effect]]
        width = [(case["size_found"], case[_NUMBERS[hidden]]) for case in first]
        near = sum(abs(found[0] / true - 1.0) < 0.1 for found, true in width)
        holds = sum(_holds(found, true) for found, true in width)
        lines.append(
            f"{effect}: {len(first)} of {len(some)} named first,"
            f" {near} to 10 %, {holds} in their interval"
        )
    none = [case for case in cases if case["hidden"] == "nothing"]
    right = sum(not case["effects"] for case in none)
    wrong = [
        name for case in cases for name in case["effects"] if name != _EFFECTS.get(case["hidden"])
    ]
    holds = sum(_holds(case["friction_found"], case["friction"]) for case in cases)
    off = [abs(case["friction_found"][0] / case["friction"] - 1.0) for case in cases]
    return "\n".join(
        [
            *lines,
            f"nothing hidden: {right} of {len(none)} without an effect; wrong names: {wrong}",
            f"friction: {holds} of {len(cases)} in their interval;"
            f" off by {np.median(off):.1%} in the median, by {max(off):.1%} at most",
        ]
    )
