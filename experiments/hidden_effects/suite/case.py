"""One hidden case: draw the reference, find the effect's strength, record, write key and files."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from experiments.hidden_effects.effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.effects.joint_effects import JOINT_EFFECTS
from experiments.hidden_effects.references import excitation
from experiments.hidden_effects.references.bench import ReferenceBench
from experiments.hidden_effects.references.joint import ReferenceJoint
from experiments.hidden_effects.suite.case_draws import (
    draw_bench,
    draw_effect,
    draw_parameters,
    known_parameters,
)
from experiments.hidden_effects.suite.case_plan import CasePlan
from experiments.hidden_effects.suite.noisy_recording import noisy_recording
from experiments.hidden_effects.suite.strength_search import (
    FoundStrength,
    calibration_projector,
    find_strength,
)
from tendon_mj.recordings import write_recording

FloatArray = NDArray[np.float64]
R = TypeVar("R", ReferenceBench, ReferenceJoint)

LEAST_TENSION = 0.05  # of the pretension; below it the tendon counts as slack
MAX_ATTEMPTS = 6  # to find an excitation under which the tendon stays taut
PERTURBATION = 1.01  # factor on a parameter, to find the sensitivity of the readings to it


def make_case(plan: CasePlan, folder: Path) -> dict[str, Any]:
    """Write the recordings of a case and ``case.json``, and return its key."""
    rng = np.random.default_rng(plan.seed)
    if plan.kind == "joint":
        joint = ReferenceJoint(**draw_parameters(ReferenceJoint, rng))
        joint_effects = [JOINT_EFFECTS[name](rng) for name in plan.names]
        uncertain = tuple(joint.description.uncertain)
        return _make(plan, folder, rng, joint, joint_effects, uncertain)
    bench, uncertain = draw_bench(plan, rng)
    hidden = [draw_effect(plan.kind, name)(rng) for name in plan.names]
    return _make(plan, folder, rng, bench, hidden, uncertain)


@dataclass(frozen=True, kw_only=True)
class _Simulated(Generic[R]):
    """Excitation of a case, and the readings of its reference.

    Attributes:
        drives: of the training recordings, then of those held out, in the drive's unit.
        readings: (sensors, samples) of each drive, without noise.
        noise: (sensors,) standard deviations in the sensors' units.
        found: strength of each hidden effect.
        truth: the reference with all effects.
        least_tension: lowest tension in all readings [N].
    """

    drives: dict[str, FloatArray]
    readings: list[FloatArray]
    noise: FloatArray
    found: list[FoundStrength]
    truth: R
    least_tension: float


def _make(
    plan: CasePlan,
    folder: Path,
    rng: np.random.Generator,
    reference: R,
    hidden: Sequence[HiddenEffect[R]],
    uncertain: tuple[str, ...],
) -> dict[str, Any]:
    simulated = _simulate(plan, rng, reference, hidden, uncertain)
    _write_recordings(plan, folder, rng, reference, simulated, uncertain)
    public = json.dumps({"exclude": plan.exclude}) + "\n"
    (folder / "case.json").write_text(public, encoding="utf-8")
    true: dict[str, float] = {}
    for one, found in zip(hidden, simulated.found, strict=True):
        true |= one.parameters(simulated.truth, found.strength)
    model_parameters = reference.description.uncertain
    return {
        "kind": plan.kind,
        "hidden": list(plan.names),
        "exclude": list(plan.exclude),
        "target": plan.target,
        "noise": plan.noise,
        "ratio": [f.ratio for f in simulated.found],
        "reached": all(f.reached for f in simulated.found),
        "strength": [f.strength for f in simulated.found],
        "parameters": true,
        "calibrated": {
            p: getattr(simulated.truth, n) for n in uncertain for p in model_parameters[n]
        },
        "least_tension_N": simulated.least_tension,
    }


def _simulate(
    plan: CasePlan,
    rng: np.random.Generator,
    reference: R,
    hidden: Sequence[HiddenEffect[R]],
    uncertain: tuple[str, ...],
) -> _Simulated[R]:
    """Simulate the reference with its effects; where the tendon goes slack, at less amplitude."""
    stated = reference.description
    tensions = [k for k, column in enumerate(stated.sensors) if column.endswith("_N")]
    scale = 0.9 * reference.pretension / stated.ranges["pretension"].value * stated.travel
    for _ in range(MAX_ATTEMPTS):
        training: list[FloatArray] = excitation.train(rng, scale)
        held_out: list[FloatArray] = excitation.held_out(rng, scale)
        baseline = reference.simulate(training, fine=False)
        noise = plan.noise * np.ptp(np.concatenate(baseline, axis=1), axis=1)
        found = [
            _find_strength(plan, reference, one, training, baseline, noise, uncertain)
            for one in hidden
        ]
        truth = reference
        for one, strength in zip(hidden, found, strict=True):
            truth = one.apply(truth, strength.strength)
        readings = truth.simulate([*training, *held_out])
        least = float(min(r[tensions].min() for r in readings))
        if least > LEAST_TENSION * reference.pretension:
            break
        scale *= 0.85
    drives = {f"train_{k}": drive for k, drive in enumerate(training, 1)}
    drives |= {f"held_out_{k}": drive for k, drive in enumerate(held_out, 1)}
    return _Simulated(
        drives=drives,
        readings=readings,
        noise=noise,
        found=found,
        truth=truth,
        least_tension=least,
    )


def _write_recordings(
    plan: CasePlan,
    folder: Path,
    rng: np.random.Generator,
    reference: R,
    simulated: _Simulated[R],
    uncertain: tuple[str, ...],
) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    model = reference.write_model(folder.parent)
    stated = reference.description
    ranges = {p: stated.ranges[n] for n in uncertain for p in stated.uncertain[n]}
    known = known_parameters(plan, reference)
    for (name, drive), readings in zip(simulated.drives.items(), simulated.readings, strict=True):
        bare = noisy_recording(reference, model, rng, name, drive, readings, simulated.noise)
        recording = dataclasses.replace(bare, known=known, uncertain=ranges)
        write_recording(recording, folder / name)


def _find_strength(
    plan: CasePlan,
    reference: R,
    hidden: HiddenEffect[R],
    drives: Sequence[FloatArray],
    baseline: Sequence[FloatArray],
    noise: FloatArray,
    uncertain: tuple[str, ...],
) -> FoundStrength:
    """Find the strength that leaves the plan's ratio once uncertain parameters are calibrated."""

    def whitened(other: R) -> FloatArray:
        runs = other.simulate(drives, fine=False)
        return np.concatenate(
            [((a - b) / noise[:, None]).ravel() for a, b in zip(runs, baseline, strict=True)]
        )

    def sensitivity(name: str) -> FloatArray:
        perturbed = {name: PERTURBATION * getattr(reference, name)}
        return whitened(dataclasses.replace(reference, **perturbed))

    uncalibrated = calibration_projector([sensitivity(name) for name in uncertain])

    def ratio(strength: float) -> float:
        residual = uncalibrated(whitened(hidden.apply(reference, strength)))
        return float(np.sqrt(np.mean(residual**2)))

    return find_strength(ratio, plan.target, hidden.low, hidden.high, hidden.start)
