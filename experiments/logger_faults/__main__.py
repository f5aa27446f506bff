"""`python -m experiments.logger_faults`: faults of loggers, named by a check or by a diagnosis."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.command import run_experiment, write_study
from experiments.logger_faults.faults import FAULTS, Fault
from experiments.logger_faults.rigs import CLEAN, MOTIONS, RIGS, record
from tendon_mj import diagnose
from tendon_mj.cli import Output, progress_bar
from tendon_mj.lab.data_check import DataWarning, check_recording

_POINTS = "points"


@dataclass(frozen=True)
class Case:
    """One recording, and its reports.

    Attributes:
        fault: its kind; empty if there is none.
        rig, motion: of the recording.
        warnings: of the check.
        named: whether they name the fault at the right place.
        verdict: of a diagnosis; empty if none was made.
        effects: of the rig that a diagnosis names.
    """

    fault: str
    rig: str
    motion: str
    warnings: tuple[DataWarning, ...]
    named: bool = False
    verdict: str = ""
    effects: tuple[str, ...] = ()


def faulty(fault: str, rig: str, seed: int, folder: Path) -> tuple[Fault, str]:
    """A recording of a rig with a fault, and its motion."""
    random = np.random.default_rng([seed, list(FAULTS).index(fault), list(RIGS).index(rig)])
    # held for a few samples, a command of stairs is what it was
    motion = random.choice(MOTIONS[:3] if fault == "held drive" else MOTIONS)
    name = f"{fault} {rig} {seed}".replace(" ", "_")
    return FAULTS[fault](record(RIGS[rig], random, motion, folder, name), random), str(motion)


def check_faulty(fault: str, rig: str, seed: int, folder: Path, *, find: bool = False) -> Case:
    """Check a recording with a fault, and diagnose it if ``find``."""
    made, motion = faulty(fault, rig, seed, folder)
    warnings = check_recording(made.recording).warnings
    named = any(made.named_by(warning) for warning in warnings)
    if not find:
        return Case(fault, rig, motion, warnings, named)
    diagnosis = diagnose([made.recording])
    effects = tuple(e for e in diagnosis.effects if not e.startswith("sensor_"))
    return Case(fault, rig, motion, warnings, named, diagnosis.verdict, effects)


def check_clean(rig: str, motion: str, seed: int, folder: Path) -> Case:
    """Check a recording without a fault, of a rig that may strike a stop or stick and slip."""
    random = np.random.default_rng([seed, list(CLEAN).index(rig), len(motion)])
    name = f"clean {rig} {motion} {seed}".replace(" ", "_")
    made = record(CLEAN[rig], random, motion, folder, name)
    return Case("", rig, motion, check_recording(made).warnings)


def logger_faults(
    out: Path = Path("out/logger_faults"),
    seeds: int = 1,
    first: int = 1,
    rigs: tuple[str, ...] = tuple(RIGS),
    diagnoses: bool = True,
) -> None:
    """Check made recordings of five rigs with one fault of a column each, and as many without.

    Args:
        out: folder for result.json, the table, and the models.
        seeds: recordings of each kind of fault on each rig.
        first: seed of the first of them.
        rigs: on which these are made.
        diagnoses: whether those with a fault are diagnosed too (a few seconds each).
    """
    output = Output(out)
    models = out / "models"
    models.mkdir(exist_ok=True)
    cases: list[Case] = []
    jobs = [(f, r, s) for s in range(first, first + seeds) for f in FAULTS for r in rigs]
    clean = [(r, m, s) for s in range(first, first + 3) for r in CLEAN for m in (*MOTIONS, _POINTS)]
    with progress_bar() as progress:
        for k, job in enumerate(jobs):
            progress("with a fault", k, len(jobs))
            cases.append(check_faulty(*job, models, find=diagnoses))
        for k, sound in enumerate(clean):
            progress("without", k, len(clean))
            cases.append(check_clean(*sound, models))
    write_study(output, [], _result(cases), table(cases), summary(cases))


def _result(cases: Sequence[Case]) -> dict[str, object]:
    return {
        "cases": [
            vars(case) | {"warnings": [warning.result() for warning in case.warnings]}
            for case in cases
        ]
    }


def table(cases: Sequence[Case]) -> str:
    """Table in Markdown: kind of fault, number named, and verdicts."""
    rows = [
        "| fault | named at its place | verdicts | effects of the rig named |",
        "|---|---|---|---|",
    ]
    for fault in dict.fromkeys(case.fault for case in cases if case.fault):
        own = [case for case in cases if case.fault == fault]
        verdicts = [case.verdict for case in own if case.verdict]
        counts = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
        named = sum(case.named for case in own)
        effects = sum(bool(case.effects) for case in own)
        rows.append(f"| {fault} | {named} of {len(own)} | {counts} | {effects} |")
    return "\n".join(rows) + "\n"


def summary(cases: Sequence[Case]) -> list[str]:
    """The figures that count, a line each."""
    with_fault = [case for case in cases if case.fault]
    without = [case for case in cases if not case.fault]
    named = sum(case.named for case in with_fault)
    diagnosed = [case for case in with_fault if case.verdict]
    wrong = [case for case in diagnosed if case.effects]
    lines = [
        f"{named} of {len(with_fault)} faults named at the right place",
        f"{sum(bool(case.warnings) for case in without)} of {len(without)} clean recordings warned"
        " of",
        f"{len(wrong)} of {len(diagnosed)} diagnoses name an effect of the rig in place of a fault",
    ]
    missed = [case for case in with_fault if not case.named]
    lines += [f"missed: {_place(case)}" for case in missed]
    lines += [f"{_place(case)}: {', '.join(case.effects)}" for case in wrong]
    return lines + _sentences(without)


def _sentences(cases: Sequence[Case]) -> list[str]:
    return [warning.sentence for case in cases for warning in case.warnings]


def _place(case: Case) -> str:
    return f"{case.fault}, {case.rig}, {case.motion}"


if __name__ == "__main__":
    sys.exit(run_experiment(logger_faults, "logger_faults"))
