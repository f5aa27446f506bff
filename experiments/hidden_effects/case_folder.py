"""Folders of a suite's cases as any tool reads them, and of its results as the scorer does."""

from __future__ import annotations

import contextlib
import hashlib
import json
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from tendon_mj import load_model
from tendon_mj.errors import InvalidValueError, RecordingError, TendonError
from tendon_mj.lab.recordings import Recording, read_recording
from tendon_mj.lab.workers import Workers, run_tasks, versions
from tendon_mj.models import model_digest
from tendon_mj.whole_file import whole_file

SOURCES = ("tendon_mj", "experiments")  # that workers need the same of


@dataclass(frozen=True, kw_only=True)
class Case:
    """Data of a case that a tool is given.

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
    """Read the recordings of a case and its ``case.json``, never the keys.

    Raises:
        TendonError: a recording, the model or ``case.json`` cannot be read, or nothing is recorded.
    """
    train = _recordings(folder, "train")
    if not train:
        raise RecordingError(f"{folder}: no train_*.csv, so there is nothing to explain")
    about = folder / "case.json"
    try:
        exclude = json.loads(about.read_text(encoding="utf-8"))["exclude"]
        if not isinstance(exclude, list) or not all(isinstance(one, str) for one in exclude):
            raise TypeError(f"exclude is {exclude!r}")
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise RecordingError(f'{about}: it is not like {{"exclude": []}} ({error})') from error
    return Case(
        name=folder.name,
        train=train,
        held_out=_recordings(folder, "held_out"),
        exclude=exclude,
        model=_model_of(train[0]),
    )


def _digests(folder: Path) -> list[object]:
    """Identity of an outcome: digest of a case's files and model, and versions of the code."""
    whole = hashlib.sha256()
    for path in sorted(p for p in folder.iterdir() if p.is_file()):
        whole.update(path.name.encode() + path.read_bytes())
    with contextlib.suppress(TendonError, OSError, ValueError):  # else that is the outcome
        first = read_recording(min(folder.glob("train_*.csv")))
        whole.update(model_digest(_model_of(first)).encode())
    return [whole.hexdigest()[:16], versions(SOURCES)]


def _model_of(recording: Recording) -> mujoco.MjModel:
    return load_model(recording.model, beside=recording.beside)


@dataclass(frozen=True)
class Solved:
    """Outcome of a case: content of result.json (None if it failed), and of run.json."""

    result: dict[str, Any] | None
    seconds: float
    error: str

    @property
    def summary(self) -> str:
        """The verdict and its effects in a line, or why there is none."""
        if self.result is None:
            return self.error.replace("\n", "; ")
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
        # before a case is read: of one that is changed later the outcome does not count
        self._of = {name: _digests(folder) for name, folder in cases.items()}

    def done(self) -> set[str]:
        """Names of the cases whose outcome is of the files that are there, and of this code."""
        if self._again:
            return set()
        return {name for name in self._cases if self._is_done(name)}

    def _is_done(self, name: str) -> bool:
        out = self._folder / name
        try:
            about = json.loads((out / "run.json").read_text(encoding="utf-8"))
            if not about["error"]:
                json.loads((out / "result.json").read_text(encoding="utf-8"))["verdict"]
            return bool(about["of"] == self._of[name])
        except (OSError, ValueError, KeyError, TypeError, RecursionError):  # not there, or broken
            return False

    def write(self, key: str, result: Solved) -> None:
        """Keep the outcome of a case."""
        out = self._folder / key
        out.mkdir(parents=True, exist_ok=True)
        if result.result is not None:
            text = json.dumps(result.result, indent=1, allow_nan=False) + "\n"
            with whole_file(out / "result.json") as made:
                made.write_text(text, encoding="utf-8")
        else:
            (out / "result.json").unlink(missing_ok=True)
        about = {"seconds": result.seconds, "error": result.error, "of": self._of[key]}
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
        solve: function that runs on each case, in other processes.
        suite: folder of cases.
        out: folder for a folder per case.
        cases: the first so many only; 0 is all.
        again: solve also cases that already have a result of the same files and code.
        processes, workers, scheduler: see `Workers`.

    Raises:
        RecordingError: the suite has no case.
        InvalidValueError: ``out`` is the suite, or ``cases`` is negative.
        TendonError: see `Workers` and `run_tasks`. A case that cannot be read or solved is none.
    """
    folders = {p.parent.name: p.parent for p in sorted(suite.glob("*/case.json"))}
    if cases < 0:
        raise InvalidValueError(f"cases = {cases} must be ≥ 0")
    if out.resolve() == suite.resolve():
        raise InvalidValueError(
            f"{out}: outcomes would be read as files of the cases; give another"
        )
    if not folders:
        raise RecordingError(f"{suite}: no folder in it has a case.json, which a suite has")
    names = list(folders)[:cases] if cases else list(folders)
    on = Workers(processes=processes, workers=workers, scheduler=scheduler)
    store = SolvedCases(out, {name: folders[name] for name in names}, again)
    run_tasks(_one, solve, names, lambda n: _read(folders[n]), store, on=on, sources=SOURCES)


def _read(folder: Path) -> Case | str:
    """A case, or why it cannot be read."""
    try:
        return read_case(folder)
    except (TendonError, OSError) as error:
        return str(error)


def _one(solve: Solve, case: Case | str) -> Solved:
    """Outcome of one case."""
    if isinstance(case, str):
        return Solved(None, 0.0, case)
    begun, error, result = time.monotonic(), "", None
    try:
        result = solve(case)
    except TendonError as failure:
        error = str(failure)
    return Solved(result, time.monotonic() - begun, error)


def _recordings(case: Path, kind: str) -> list[Recording]:
    return [read_recording(path) for path in sorted(case.glob(f"{kind}_*.csv"))]
