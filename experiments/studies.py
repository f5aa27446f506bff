"""`python -m experiments.studies`: studies of real data, and what their READMEs state of them.

A change of the search, the selection or the proof may be right on every simulated rig and lose a
real one. Errors may be smaller than stated; other numbers, verdicts and names are to be the same.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from experiments import cable_tool, measured_joint, positioning_system
from experiments.cable_tool.recording import read_folder as read_tool
from experiments.cable_tool.report import mean_and_worst
from experiments.cable_tool.study import run_study as study_tool
from experiments.command import measured_data, run_experiment
from experiments.measured_joint.recording import ANGLE, TENSIONS
from experiments.measured_joint.recording import read_folder as read_joint
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT
from experiments.measured_joint.study import run_study as study_joint
from experiments.positioning_system.descriptions import NAMES
from experiments.positioning_system.measurement import read_measurement
from experiments.positioning_system.report import NUMBERS, offset, scale
from experiments.positioning_system.study import run_study as study_positioning
from tendon_mj import Diagnosis
from tendon_mj.cli import console, progress_bar
from tendon_mj.errors import TendonError
from tendon_mj.lab.progress import Progress

_WITHIN = 0.05  # of a figure: where a fit ends in a flat valley moves errors by 3 %
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
StudyName = Literal["cable_tool", "measured_joint", "positioning_system"]


@dataclass(frozen=True)
class Figure:
    """Numbers or words that a README states and a study measures."""

    row: str  # first cell of a row of the README's tables
    cell: int  # of that row
    measured: tuple[float, ...] | str
    errors: bool = True  # whether numbers may be smaller than stated
    table: int = 0  # of those with such a row

    def stated(self, page: str) -> str:
        """Cell of a README, without emphasis and what is in brackets."""
        plain = page.translate({ord("*"): None, ord("`"): None, ord("−"): "-"})
        lines = [line.strip("| ").split(" | ") for line in plain.splitlines() if line[:1] == "|"]
        rows = [cells for cells in lines if cells[0] == self.row]
        if len(rows) <= self.table or len(rows[self.table]) <= self.cell:
            raise TendonError(f"the README has no row {self.row!r} with cell {self.cell}")
        return re.sub(r" *\(.*?\)", "", rows[self.table][self.cell])

    def agrees(self, page: str) -> bool:
        """Return whether the README states it."""
        stated = self.stated(page)
        if isinstance(self.measured, str):
            return stated == self.measured
        numbers = [float(number) for number in _NUMBER.findall(stated)][: len(self.measured)]
        return len(numbers) == len(self.measured) and all(
            new - old <= _WITHIN * abs(old) and (self.errors or old - new <= _WITHIN * abs(old))
            for old, new in zip(numbers, self.measured, strict=True)
        )


def studies(only: Sequence[StudyName] = ()) -> None:
    """Run the studies of real data, and compare with the figures that their READMEs state.

    Needs TENDON_MJ_DATA. Takes about 40 min on two cores.

    Args:
        only: studies to run; default: all.
    """
    made = {
        cable_tool: _cable_tool,
        measured_joint: _measured_joint,
        positioning_system: _positioning_system,
    }
    wrong = []
    for package, figures in made.items():
        name = package.__name__.rpartition(".")[2]
        if only and name not in only:
            continue
        page = (Path(package.__path__[0]) / "README.md").read_text("utf-8")
        with progress_bar() as progress:
            for figure in figures(progress):
                line = f"{name}, {figure.row!r}, cell {figure.cell}: stated"
                line += f" {figure.stated(page)}, measured {_words(figure.measured)}"
                console.print(line, soft_wrap=True, highlight=False)
                wrong += [] if figure.agrees(page) else [line]
    if wrong:
        raise TendonError("figures differ from those that READMEs state:\n" + "\n".join(wrong))


def _words(measured: tuple[float, ...] | str) -> str:
    return measured if isinstance(measured, str) else ", ".join(f"{x:.4g}" for x in measured)


def _verdict(diagnosis: Diagnosis) -> str:
    between = ": " if diagnosis.proven else ", closest "
    return diagnosis.verdict + between + ", ".join(diagnosis.effects or diagnosis.closest)


def _cable_tool(progress: Progress) -> Iterator[Figure]:
    study = study_tool(read_tool(measured_data("cable_tool")), 0, progress)
    columns = ("load", "straight"), ("pose", "pitch"), ("pose", "roll"), ("rate", "straight")
    for cell, (left_out, group) in enumerate(columns, 2):
        error = mean_and_worst(study.chosen(left_out, group), "torque")
        if error:
            yield Figure("sheath and constant friction", cell, (1e3 * error[0],))
    yield Figure("friction_exponent λ, straight wrist", 1, (study.tool.friction_exponent,), False)


def _measured_joint(progress: Progress) -> Iterator[Figure]:
    recordings = read_joint(measured_data("tendon_sheath_joint"))
    study = study_joint(recordings, progress=progress, candidates=())
    errors = [e for split in (BETWEEN, BEYOND) for e in study.diagnosed_errors(split)]
    for cell, one in enumerate(errors):
        yield Figure("diagnosis", cell + 2, (math.degrees(one.rms[ANGLE]),))
        yield Figure("diagnosis", cell + 1, tuple(one.rms[c] for c in TENSIONS), table=1)
    left = study.diagnosed_errors(LEFT_OUT)
    yield Figure("diagnosis", 6, (math.degrees(sum(e.rms[ANGLE] for e in left) / len(left)),))
    rows = [("0, 120, 240", study.diagnoses[BETWEEN][0]), ("0, 120", study.diagnoses[BEYOND][0])]
    rows += [(f"all but {d.shown[0].errors[1].bend}", d) for d in study.diagnoses[LEFT_OUT]]
    for row, diagnosed in rows:
        yield Figure(row, 1, _verdict(diagnosed.found))
        friction = diagnosed.found.parameters.get("sheath_1.friction")
        if friction and not row.startswith("all but"):
            yield Figure(row, 2, (friction.value,), False)


def _positioning_system(progress: Progress) -> Iterator[Figure]:
    measurement = read_measurement(measured_data("positioning_system/emps.csv"))
    cell = 0
    for name, one in study_positioning(measurement, progress).described.items():
        diagnosis = one.diagnosis
        yield Figure(NAMES[name], 1, diagnosis.verdict)
        yield Figure(NAMES[name], 2, ", ".join(diagnosis.effects))
        values = [*(diagnosis.model[parameter] for parameter in NUMBERS), offset(diagnosis.model)]
        for place, value in enumerate(values, 3):
            yield Figure(NAMES[name], place, (value,), False)
        for column, error in one.errors["after"].items():
            cell += 1
            yield Figure("found", cell, (scale(name, column) * error,))


if __name__ == "__main__":
    sys.exit(run_experiment(studies, "studies"))
