"""The whole study: a diagnosis of each description, beside the published model and mujoco.sysid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from experiments.positioning_system import published
from experiments.positioning_system.descriptions import describe
from experiments.positioning_system.measurement import Measurement
from tendon_mj.lab.diagnosis import Diagnosis, SysidResult, diagnose, fit_with_sysid, sysid_is_there
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import FloatArray

HELD_OUT = 0.25  # last share of the recording, which `diagnose` and `fit_with_sysid` do not fit
TOLD = "sysid, told the structure"
# Known numbers, and the ranges of the uncertain ones.
STRUCTURE = {
    "screw.damping": Uncertain(100.0, 0.0, 1000.0),
    "screw.frictionloss": Uncertain(10.0, 0.0, 100.0),
    "gravity.x": Uncertain(0.0, -0.5, 0.5),
}


@dataclass(frozen=True)
class Described:
    """Findings for one description.

    Attributes:
        recording: the description and its columns.
        diagnosis: from the frictionless model.
        errors: model → measured column → held-out error, rms [the column's unit].
        residuals: likewise, over all samples (n,), simulated − measured.
        sysid: `mujoco.sysid` told nothing but that the mass is uncertain, and told the structure;
            None if it is not installed.
    """

    recording: Recording
    diagnosis: Diagnosis
    errors: Mapping[str, Mapping[str, float]]
    residuals: Mapping[str, Mapping[str, FloatArray]]
    sysid: tuple[SysidResult, SysidResult] | None


@dataclass(frozen=True)
class Study:
    """Findings.

    Attributes:
        measurement: the file.
        described: description → result.
    """

    measurement: Measurement
    described: Mapping[str, Described]


def run_study(measurement: Measurement, progress: Progress = silent) -> Study:
    """Diagnose every description."""
    recordings = describe(measurement)
    return Study(
        measurement, {name: _study(recording, progress) for name, recording in recordings.items()}
    )


def _study(recording: Recording, progress: Progress) -> Described:
    diagnosis = diagnose([recording], progress=progress)
    sysid = None
    if sysid_is_there():
        told = replace(recording, uncertain={**recording.uncertain, **STRUCTURE})
        sysid = (
            fit_with_sysid([recording], progress=progress),
            fit_with_sysid([told], progress=progress),
        )
    models: dict[str, Mapping[str, float]] = {
        "before": {name: diagnosis.before[name] for name in diagnosis.calibrated},
        "after": diagnosis.fitted,
        "published": published.PARAMETERS,
    }
    if sysid:
        values = (one.values.items() for one in sysid)
        before, told_all = ({name: v for name, (v, _, _) in one} for one in values)
        models |= {"sysid": before, TOLD: told_all}
    answers = Simulator([recording])(list(models.values()))
    residuals = {
        model: {column: series - recording.columns[column] for column, series in answer.items()}
        for model, (answer,) in zip(models, answers, strict=True)
    }
    time = recording.time
    held_out = time > time[0] + (1.0 - HELD_OUT) * (time[-1] - time[0])
    errors = {
        model: {c: float(np.sqrt(np.mean(r[held_out] ** 2))) for c, r in columns.items()}
        for model, columns in residuals.items()
    }
    return Described(recording, diagnosis, errors, residuals, sysid)
