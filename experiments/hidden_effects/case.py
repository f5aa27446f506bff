"""One hidden case: draw it, find its strengths, simulate it, write its files and its key."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Generic
from xml.etree import ElementTree

import numpy as np

from experiments.hidden_effects import excitation
from experiments.hidden_effects.draws import CaseDraw, draw_bench, draw_joint
from experiments.hidden_effects.plan import REAL_KINDS, CasePlan
from experiments.hidden_effects.references import (
    R,
    ReferenceBench,
    ReferenceJoint,
)
from experiments.hidden_effects.sessions import (
    RigState,
    Sessions,
    draw_bends,
    draw_sessions,
    reproducibility,
)
from experiments.hidden_effects.strengths import Strengths, Trial, find_strengths, simulate_each
from tendon_mj.lab.recordings import Measured, Recording, write_recording
from tendon_mj.lab.replay import patch_model
from tendon_mj.typing import FloatArray

QUANTISATION = 1.0 / 3.0  # step of the readings over their noise [-]
MODEL = "model.xml"
NAMES = (*(f"train_{k}" for k in range(1, 5)), *(f"held_out_{k}" for k in (1, 2)))
OF_DRAWN = ("train_1", "train_2", "held_out_1")  # of kind "drawn"
LEAST_TENSION = 0.05  # of the pretension; below it the tendon counts as slack
MAX_ATTEMPTS = 6  # to find an excitation under which the tendon stays taut


def noisy_recording(
    reference: ReferenceBench | ReferenceJoint,
    model: str,
    rng: np.random.Generator,
    name: str,
    drive: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
) -> Recording:
    """Readings with noise and quantisation as a recording that states no parameter.

    Args:
        reference: that was simulated.
        model: to which the recording refers.
        rng: of the noise.
        name: of the recording.
        drive: (samples,) in the drive's unit.
        readings: (sensors, samples) without noise.
        noise: (sensors,) standard deviations in the sensors' units.
    """
    stated = reference.description
    columns, measured = {stated.drive: drive}, {}
    sensors = zip(stated.sensors.items(), readings, noise, strict=True)
    for (column, sensor), values, sigma in sensors:
        digit = float(f"{QUANTISATION * sigma:.2g}")
        noisy = values + rng.normal(0.0, sigma, len(values))
        columns[column] = np.round(np.round(noisy / digit) * digit, 9)
        measured[column] = Measured(sensor, float(f"{sigma:.4g}"))
    rate = reference.rate
    return Recording(
        name=name,
        model=model,
        source="made by tendon-mj, not measured: experiments/hidden_effects; Apache-2.0",
        time=excitation.clock(len(drive) / rate, rate)[: len(drive)],
        columns=columns,
        drive={stated.drive: stated.actuator},
        measured=measured,
    )


def write_case(
    plan: CasePlan,
    folder: Path,
    rng: np.random.Generator,
    draw: CaseDraw[R],
    raised: Mapping[str, float],
    sessions: Sessions,
    series: Mapping[str, tuple[FloatArray, FloatArray]],
    noise: FloatArray,
) -> None:
    """Write the files of a case.

    Args:
        plan, draw: the case.
        folder: for the files.
        rng: of the noise.
        raised: parameter → value of the model, where that is too high.
        sessions: state of the rig in every recording.
        series: recording → its drive, and (sensors, samples) readings without noise.
        noise: (sensors,) standard deviations in the sensors' units.
    """
    folder.mkdir(parents=True, exist_ok=True)
    reference, stated = draw.reference, draw.reference.description
    own = plan.kind in REAL_KINDS
    model = _write_model(reference, folder, raised) if own else reference.write_model(folder.parent)
    if Path(model).is_absolute():
        model = f"../{Path(model).name}"  # beside the cases, wherever the suite is moved to
    ranges = {p: stated.ranges[n] for n in draw.uncertain for p in stated.uncertain[n]}
    for (name, (drive, readings)), state in zip(series.items(), sessions.states, strict=True):
        bare = noisy_recording(reference, model, rng, name, drive, readings, noise)
        bends = {"drawn_bend": type(reference).bend, "extra_bend": state.extra_bend}
        bend = {f"{s}.{name}": value for s in stated.sheaths for name, value in bends.items()}
        recording = dataclasses.replace(
            bare,
            known={**draw.known, **(bend if plan.bends else {})},
            uncertain=ranges,
            session=sessions.stated,
        )
        write_recording(recording, folder / name)
    public = json.dumps({"exclude": plan.exclude}) + "\n"
    (folder / "case.json").write_text(public, encoding="utf-8")


def _write_model(
    reference: ReferenceBench | ReferenceJoint, folder: Path, raised: Mapping[str, float]
) -> str:
    """Write the model into the case's folder, without a comment on the raised numbers."""
    with TemporaryDirectory() as base:
        patch_model(reference.write_model(Path(base)), raised, folder / MODEL)
    text = ElementTree.parse(folder / MODEL)  # drops comments
    text.write(folder / MODEL, encoding="unicode")
    return MODEL


def make_case(plan: CasePlan, folder: Path) -> dict[str, Any]:
    """Write the recordings of a case and ``case.json``, and return its key."""
    rng = np.random.default_rng(plan.seed)
    if plan.rig == "joint":
        return _make(plan, folder, rng, draw_joint(plan, rng))
    return _make(plan, folder, rng, draw_bench(plan, rng))


@dataclass(frozen=True, kw_only=True)
class _Simulated(Generic[R]):
    """Excitation of a case, and the readings of its reference.

    Attributes:
        drives: of the training recordings, then of those held out, in the drive's unit.
        readings: (sensors, samples) of each drive, without noise.
        noise: (sensors,) standard deviations in the sensors' units.
        strengths: of the hidden effects.
        sessions: state of the rig in each recording.
        left: of the reproducibility between sessions, once calibrated [noise].
        least_tension: lowest tension in all readings [N].
    """

    drives: list[FloatArray]
    readings: list[FloatArray]
    noise: FloatArray
    strengths: Strengths[R]
    sessions: Sessions
    left: float
    least_tension: float


def _make(
    plan: CasePlan, folder: Path, rng: np.random.Generator, draw: CaseDraw[R]
) -> dict[str, Any]:
    simulated = _simulate(plan, rng, draw)
    hidden, sessions = simulated.strengths.hidden, simulated.sessions
    truth = simulated.strengths.applied(draw.reference)
    true: dict[str, float] = {}
    for one, result in hidden:
        true |= one.parameters(truth, result.strength)
    raised = {}
    if plan.kind == "too_high":
        ((_, result),) = hidden
        raised = {name: float(f"{value + result.strength:.4g}") for name, value in true.items()}
    write_case(
        plan,
        folder,
        rng,
        draw,
        raised,
        sessions,
        dict(
            zip(
                OF_DRAWN if plan.kind == "drawn" else NAMES,
                zip(simulated.drives, simulated.readings, strict=True),
                strict=True,
            )
        ),
        simulated.noise,
    )
    model_parameters = draw.reference.description.uncertain
    key = {
        "kind": plan.kind,
        "hidden": list(plan.names),
        "exclude": list(plan.exclude),
        "target": plan.target,
        "noise": plan.noise,
        "ratio": [f.ratio for _, f in hidden],
        "reached": all(f.reached for _, f in hidden),
        "strength": [f.strength for _, f in hidden],
        "parameters": true,
        "calibrated": {p: getattr(truth, n) for n in draw.uncertain for p in model_parameters[n]},
        "least_tension_N": simulated.least_tension,
    }
    if plan.kind in REAL_KINDS:
        key |= _beyond_noise(plan, simulated, truth, raised)
    return key


def _beyond_noise(
    plan: CasePlan, simulated: _Simulated[R], truth: R, raised: dict[str, float]
) -> dict[str, Any]:
    """Further entries of the key: the unit of the target, and other differences from the model."""
    return {
        "rig": plan.rig,
        "unit": simulated.strengths.unit,
        "left": simulated.left,
        "small": {one.name: result.ratio for one, result in simulated.strengths.small},
        "model": raised,
        "sessions": {
            name: state.parameters(truth)
            for name, state in zip(NAMES, simulated.sessions.states, strict=True)
            if plan.kind == "session"
        },
    }


def _half(drive: FloatArray) -> FloatArray:
    """The first half of a drive."""
    return drive[: len(drive) // 2]


def _excitations(
    plan: CasePlan, rng: np.random.Generator, scale: float
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Drives of the training recordings and of those held out."""
    training: list[FloatArray] = excitation.train(rng, scale)
    unseen: list[FloatArray] = excitation.held_out(rng, scale)
    if plan.kind == "drawn":
        # two of four kinds, and the first halves of all: a quarter of the time
        training = [_half(training[k]) for k in rng.permutation(4)[:2]]
        unseen = [_half(unseen[1])]
    return training, unseen


def _simulate(plan: CasePlan, rng: np.random.Generator, draw: CaseDraw[R]) -> _Simulated[R]:
    """Simulate the reference with its effects; where the tendon goes slack, at less amplitude."""
    reference, stated = draw.reference, draw.reference.description
    tensions = [k for k, column in enumerate(stated.sensors) if column.endswith("_N")]
    scale: float = 0.9 * reference.pretension / stated.ranges["pretension"].value * stated.travel
    for _ in range(MAX_ATTEMPTS):
        own = np.random.default_rng([*plan.seed, 1])  # for draws that the old kinds do not have
        training: list[FloatArray]
        unseen: list[FloatArray]
        training, unseen = _excitations(plan, rng, scale)
        drives = [*training, *unseen]
        bends = draw_bends(len(drives), own) if plan.bends else [0.0] * len(drives)
        bent = [RigState(extra_bend=b).bent(reference) for b in bends]
        if isinstance(reference, ReferenceBench):
            bent = [dataclasses.replace(r, recording=k) for k, r in enumerate(bent)]
        baseline = simulate_each(bent[: len(training)], training, fine=False)
        trial = Trial(
            references=bent[: len(training)],
            drives=training,
            readings=baseline,
            noise=plan.noise * np.ptp(np.concatenate(baseline, axis=1), axis=1),
            uncertain=draw.uncertain,
            session=plan.kind == "session",
        )
        sessions, unit, left = Sessions.one(len(drives)), 1.0, 0.0
        if plan.kind == "session":
            sessions = draw_sessions(trial, bends, own)
            unit, left = reproducibility(trial, sessions)
        strengths = find_strengths(plan, draw, trial, unit, own)
        shown = bent if plan.kind == "too_high" else [strengths.applied(r) for r in bent]
        truths = [s.set_anew(r) for s, r in zip(sessions.states, shown, strict=True)]
        ideal = simulate_each(truths, drives)
        readings = [s.read(r) for s, r in zip(sessions.states, ideal, strict=True)]
        least = float(min(r[tensions].min() for r in readings))
        if least > LEAST_TENSION * reference.pretension:
            break
        scale *= 0.85
    return _Simulated(
        drives=drives,
        readings=readings,
        noise=trial.noise,
        strengths=strengths,
        sessions=sessions,
        left=left,
        least_tension=least,
    )
