"""One hidden case on the bench: draw the rig, find the strength, record, write it down."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.hidden_effects import catalogue, excitation
from experiments.hidden_effects.catalogue import Hidden
from experiments.hidden_effects.rig import COLUMNS, Rig
from experiments.hidden_effects.strength import find, projector
from tendon_mj.simulate.bench import Bench
from tendon_mj.simulate.recording import Measured, Recording, Uncertain, write_recording

FloatArray = NDArray[np.float64]

KNOWN = {
    "sheath.axial_stiffness": Bench.axial_stiffness,
    "environment.stiffness": Bench.environment_stiffness,
    "sensor.stiffness": Bench.sensor_stiffness,
}
FRICTION = Uncertain(0.15, 0.05, 0.4)
PRETENSION = Uncertain(20.0, 15.0, 25.0)
ROUNDING = 1.0 / 3.0  # of the noise: quantisation of the readings
COARSE = 2.5e-4  # step of the search for the strength [s]
LEAST_TENSION = 1.0  # N


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a case is to be.

    Attributes:
        kind: "effect", "pair", "parameter", "nothing", "outside" or "joint".
        names: of what is hidden.
        target: wanted ratio of residual to noise, for each of them [-].
        noise: standard deviation over the range of each tension [-].
        exclude: effects to take out of the catalogue when diagnosing.
        seed: of all that is drawn.
    """

    kind: str
    names: tuple[str, ...]
    target: float
    noise: float
    exclude: tuple[str, ...]
    seed: tuple[int, ...]


def make_case(plan: Plan, folder: Path) -> dict[str, Any]:
    """Write the recordings of a case and return its key."""
    rng = np.random.default_rng(plan.seed)
    rig, uncertain = _rig(plan, rng)
    hidden = [_draw(plan.kind, name)(rng) for name in plan.names]
    scale = 0.9 * rig.pretension / Bench.pretension
    for _ in range(6):
        training, held_out = excitation.train(rng, scale), excitation.held_out(rng, scale)
        baseline = rig.run(training, COARSE)
        noise = plan.noise * np.ptp(np.concatenate(baseline, axis=1), axis=1)
        found = [_find(plan, rig, one, training, baseline, noise, uncertain) for one in hidden]
        truth = rig
        for one, strength in zip(hidden, found, strict=True):
            truth = one.apply(truth, strength.strength)
        readings = truth.run([*training, *held_out])
        if min(r.min() for r in readings) > LEAST_TENSION:
            break
        scale *= 0.85  # it went slack
    names = [f"train_{k + 1}" for k in range(len(training))]
    names += [f"held_out_{k + 1}" for k in range(len(held_out))]
    folder.mkdir(parents=True, exist_ok=True)
    for name, drive, reading in zip(names, [*training, *held_out], readings, strict=True):
        recording = _recording(plan, rig, uncertain, rng, name, drive, reading, noise)
        write_recording(recording, folder / name)
    (folder / "case.json").write_text(json.dumps({"exclude": plan.exclude}) + "\n")
    return {
        "kind": plan.kind,
        "hidden": list(plan.names),
        "exclude": list(plan.exclude),
        "target": plan.target,
        "noise": plan.noise,
        "ratio": [f.ratio for f in found],
        "reached": all(f.reached for f in found),
        "strength": [f.strength for f in found],
        "parameters": {
            k: v for one, f in zip(hidden, found, strict=True) for k, v in one.numbers(f.strength).items()
        },
        "rig": {
            "friction": truth.friction,
            "pretension": truth.pretension,
            "axial_stiffness": truth.axial_stiffness,
        },
        "least_tension_N": float(min(r.min() for r in readings)),
    }


def _draw(kind: str, name: str) -> Any:
    if name == "sheath_friction":
        return catalogue.SHEATH_FRICTION
    if kind == "parameter":
        return catalogue.PARAMETERS[name]
    return (catalogue.EFFECTS | catalogue.STRANGE)[name]


def _rig(plan: Plan, rng: np.random.Generator) -> tuple[Rig, tuple[str, ...]]:
    """The rig before anything is hidden, and what the recording calls uncertain of it."""
    drawn = {"friction": rng.uniform(0.08, 0.3), "pretension": rng.uniform(16.5, 23.5)}
    if plan.names == ("sheath_friction",):
        drawn["friction"] = 0.0
        return Rig(**drawn), ("pretension",)
    uncertain = list(drawn)
    if plan.kind == "parameter":
        wrong = plan.names[0]
        known = {"bend_angle": "friction"}.get(wrong, wrong)  # only their product shows
        if known in drawn:
            uncertain.remove(known)
            drawn[known] = getattr(Bench, known)
    return Rig(**drawn), tuple(uncertain)


def _find(
    plan: Plan,
    rig: Rig,
    hidden: Hidden,
    drives: Sequence[FloatArray],
    baseline: Sequence[FloatArray],
    noise: FloatArray,
    uncertain: tuple[str, ...],
) -> Any:
    def whitened(other: Rig) -> FloatArray:
        runs = other.run(drives, COARSE)
        return np.concatenate(
            [((a - b) / noise[:, None]).ravel() for a, b in zip(runs, baseline, strict=True)]
        )

    sensitivities = []
    for name in uncertain:
        value = 1.01 * getattr(rig, name)
        sensitivities.append(whitened(dataclasses.replace(rig, **{name: value})))
    left = projector(sensitivities)

    def ratio(strength: float) -> float:
        residual = left(whitened(hidden.apply(rig, strength)))
        return float(np.sqrt(np.mean(residual**2)))

    return find(ratio, plan.target, hidden.low, hidden.high, hidden.start)


def _recording(
    plan: Plan,
    rig: Rig,
    uncertain: tuple[str, ...],
    rng: np.random.Generator,
    name: str,
    drive: FloatArray,
    reading: FloatArray,
    noise: FloatArray,
) -> Recording:
    columns, measured = {"input_displacement_m": drive}, {}
    for column, values, sigma in zip(COLUMNS, reading, noise, strict=True):
        digit = float(f"{ROUNDING * sigma:.2g}")
        noisy = values + rng.normal(0.0, sigma, len(values))
        columns[column] = np.round(np.round(noisy / digit) * digit, 9)
        measured[column] = Measured(column.removesuffix("_N"), float(f"{sigma:.4g}"))
    known = dict(KNOWN)
    if plan.names == ("axial_stiffness",) and plan.kind == "parameter":
        del known["sheath.axial_stiffness"]
    if plan.names == ("sheath_friction",):
        known["sheath.friction"] = 0.0
    if plan.names == ("bend_angle",):
        known["sheath.friction"] = rig.friction
    ranges = {"friction": FRICTION, "pretension": PRETENSION}
    return Recording(
        name=name,
        model="bench",
        source="made by tendon-mj, not measured: experiments/hidden_effects; Apache-2.0",
        time=excitation.clock()[: len(drive)],
        columns=columns,
        drive={"input_displacement_m": "reel"},
        measured=measured,
        known=known,
        uncertain={f"sheath.{p}": ranges[p] for p in uncertain},
    )
