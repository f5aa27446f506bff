"""Folders of a suite's cases as any tool reads them, and of its results as the scorer does."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from tendon_mj import load_model
from tendon_mj.errors import TendonError
from tendon_mj.recordings import Recording, read_recording
from tendon_mj.tasks import Workers, run_tasks, versions
from tendon_mj.whole_file import whole_file

SOURCES = ("tendon_mj", "experiments")  # that workers need the same of


@dataclass(frozen=True, kw_only=True)
class Case:
    """What a tool is given of a case.

    Attributes:
        name: of its folder.
        train, held_out: recordings to explain, and those that prove it.
        exclude: effects to take out of the catalogue.
        model: that the recordings name, for workers that do not have its file.
    """

    name: str
    train: list[Recording]
    held_out: list[Recording]
    exclude: Collection[str]
    model: mujoco.MjModel | None = None


Solve = Callable[[Case], dict[str, Any]]  # case → content of result.json


def read_case(folder: Path) -> Case:
    """Read the recordings of a case and its ``case.json``, never the keys."""
    train = _recordings(folder, "train")
    return Case(
        name=folder.name,
        train=train,
        held_out=_recordings(folder, "held_out"),
        exclude=json.loads((folder / "case.json").read_text(encoding="utf-8"))["exclude"],
        model=load_model(train[0].model, beside=train[0].beside),
    )


@dataclass(frozen=True)
class Solved:
    """Outcome of a case: content of result.json (None where it failed), and of run.json."""

    result: dict[str, Any] | None
    seconds: float
    error: str

    @property
    def summary(self) -> str:
        """The verdict and its effects in a line, or why there is none."""
        if self.result is None:
            return self.error
        return f"{self.result['verdict']} {', '.join(self.result['effects'])}"


class SolvedCases:
    """Keeps a folder per case with result.json and run.json (seconds, error), and prints progress.

    Args:
        folder: of the folders.
        cases: name → folder of the case.
        again: whether cases that have an outcome are solved again.
    """

    def __init__(self, folder: Path, cases: Mapping[str, Path], again: bool) -> None:
        self._folder, self._cases, self._again = folder, cases, again
        self._begun, self._written = time.monotonic(), 0

    def done(self) -> set[str]:
        """Names of the cases whose outcome is of the files that are there, and of this code."""
        if self._again:
            return set()
        found = {p.parent.name: p for p in self._folder.glob("*/run.json")}
        return {
            name
            for name, path in found.items()
            if name in self._cases
            and json.loads(path.read_text(encoding="utf-8")).get("of") == self._of(name)
        }

    def _of(self, name: str) -> list[object]:
        """What an outcome is of: digest of a case's files, and what computes it."""
        whole = hashlib.sha256()
        for path in sorted(p for p in self._cases[name].iterdir() if p.is_file()):
            whole.update(path.name.encode() + path.read_bytes())
        return [whole.hexdigest()[:16], versions(SOURCES)]

    def write(self, key: str, result: Solved) -> None:
        """Keep the outcome of a case."""
        out = self._folder / key
        out.mkdir(parents=True, exist_ok=True)
        if result.result is not None:
            text = json.dumps(result.result, indent=1, allow_nan=False) + "\n"
            with whole_file(out / "result.json") as made:
                made.write_text(text, encoding="utf-8")
        about = {"seconds": result.seconds, "error": result.error, "of": self._of(key)}
        with whole_file(out / "run.json") as made:  # last: with it the case is done
            made.write_text(json.dumps(about) + "\n", encoding="utf-8")
        self._written += 1
        spent = time.monotonic() - self._begun
        said = f"{self._written}/{len(self._cases)}, {spent:.0f} s: {key} {result.summary}"
        print(said, flush=True)


def solve_suite(
    solve: Solve,
    suite: Path,
    out: Path,
    *,
    cases: int,
    again: bool,
    processes: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
) -> None:
    """Solve every case, keep the outcomes as they come, and print the progress.

    Args:
        solve: what is run on each case, in processes of its own.
        suite: folder of cases.
        out: folder for a folder per case.
        cases: the first so many only; 0 is all.
        again: solve also cases that already have a result of the same files and code.
        processes, workers, scheduler: see `Workers`.
    """
    folders = {p.parent.name: p.parent for p in sorted(suite.glob("*/case.json"))}
    names = list(folders)[:cases] if cases else list(folders)
    on = Workers(processes=processes, workers=workers, scheduler=scheduler)
    store = SolvedCases(out, {name: folders[name] for name in names}, again)
    run_tasks(_one, solve, names, lambda n: read_case(folders[n]), store, on=on, sources=SOURCES)


def _one(solve: Solve, case: Case) -> Solved:
    """Outcome of one case."""
    begun, error, result = time.monotonic(), "", None
    try:
        result = solve(case)
    except TendonError as failure:
        error = str(failure)
    return Solved(result, time.monotonic() - begun, error)


def _recordings(case: Path, kind: str) -> list[Recording]:
    return [read_recording(path) for path in sorted(case.glob(f"{kind}_*.csv"))]
