"""Files of a case: its recordings, the model that they refer to, and ``case.json``."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

import numpy as np

from experiments.hidden_effects.references.bench import ReferenceBench
from experiments.hidden_effects.references.joint import ReferenceJoint
from experiments.hidden_effects.suite.case_draws import CaseDraw
from experiments.hidden_effects.suite.case_plan import REAL_KINDS, CasePlan
from experiments.hidden_effects.suite.noisy_recording import noisy_recording
from experiments.hidden_effects.suite.rig_state import R
from experiments.hidden_effects.suite.sessions import Sessions
from tendon_mj.lab.recordings import write_recording
from tendon_mj.lab.replay import patch_model
from tendon_mj.typing import FloatArray

MODEL = "model.xml"


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
    """Write the model into the case's folder, without a comment on what was raised in it."""
    with TemporaryDirectory() as base:
        patch_model(reference.write_model(Path(base)), raised, folder / MODEL)
    text = ElementTree.parse(folder / MODEL)  # drops comments
    text.write(folder / MODEL, encoding="unicode")
    return MODEL
