"""Makes a suite of hidden cases from a seed; `python -m experiments.hidden_effects.make --help`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import tyro

from experiments.hidden_effects.case import make_case
from experiments.hidden_effects.case_folder import SOURCES
from experiments.hidden_effects.plan import KINDS, CasePlan, Kind, plan_suite
from tendon_mj.lab.workers import Workers, run_tasks, versions
from tendon_mj.whole_file import whole_file


@dataclass(frozen=True, kw_only=True)
class Suite:
    """Hidden cases in one folder, and their keys in another.

    Attributes:
        out: folder for the cases.
        keys: folder for keys.json, which only the scorer may read.
        seed: of every random draw.
        kinds: of cases: effect, pair, parameter, nothing, outside, joint; and session, remainder,
            too_high, drawn.
        strengths: ratios of the residual after calibration to the noise, with one effect [-].
        noises: standard deviations over the range of the signal [-].
        repeats: of cases with one effect, a wrong parameter or an effect outside the catalogue, and
            of the last four kinds.
        nothing: cases in which nothing is hidden; of sessions a quarter as many.
        pairs: cases with two effects.
        cases: the first so many only; 0 is all.
        processes: of this machine, without Dask; default: as many as it has cores.
        workers: of a Dask cluster that lives as long as the run.
        scheduler: address of a Dask scheduler, such as tcp://10.0.0.1:8786.
    """

    out: Path
    keys: Path
    seed: int = 1
    kinds: tuple[Kind, ...] = KINDS
    strengths: tuple[float, ...] = (2.0, 5.0, 20.0)
    noises: tuple[float, ...] = (0.002, 0.01)
    repeats: int = 1
    nothing: int = 40
    pairs: int = 40
    cases: int = 0
    processes: int | None = None
    workers: int | None = None
    scheduler: str | None = None


class Made(NamedTuple):
    """A case: its key, and the files of the suite that belong to it."""

    key: dict[str, Any]
    files: dict[str, bytes]


class MadeCases:
    """Keeps the files of cases, and beside the keys' folder's keys.json each key for itself.

    Args:
        suite: where the files and the keys go.
        plans: of the cases by their names.
    """

    def __init__(self, suite: Suite, plans: dict[str, CasePlan]) -> None:
        self._suite, self._plans = suite, plans
        self._keys = suite.keys / "cases"
        self._keys.mkdir(parents=True, exist_ok=True)

    def done(self) -> set[str]:
        """Names of the cases that were made after the same plan by the same code, and are there."""
        by_name = {p.stem: p for p in self._keys.glob("case_*.json") if p.stem in self._plans}
        return {
            name
            for name, path in by_name.items()
            if json.loads(path.read_text(encoding="utf-8"))["plan"] == self._plan(name)
            and (self._suite.out / name / "case.json").exists()
        }

    def write(self, key: str, result: Made) -> None:
        """Keep a case."""
        for name, content in result.files.items():
            path = self._suite.out / name
            path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(path) as made:
                made.write_bytes(content)
        text = json.dumps({"plan": self._plan(key), "key": result.key}) + "\n"
        with whole_file(self._keys / f"{key}.json") as made:  # last: with it the case is done
            made.write_text(text, encoding="utf-8")

    def _plan(self, name: str) -> list[object]:
        return [str(self._plans[name]), versions(SOURCES)]

    def keys(self) -> dict[str, Any]:
        """The key of every case."""
        return {
            name: json.loads((self._keys / f"{name}.json").read_text(encoding="utf-8"))["key"]
            for name in self._plans
        }


def make(suite: Suite) -> None:
    """Write the cases and their keys, and print the progress."""
    todo = plan_suite(
        suite.seed,
        suite.kinds,
        suite.strengths,
        suite.noises,
        suite.repeats,
        suite.nothing,
        suite.pairs,
    )
    todo = todo[: suite.cases] if suite.cases else todo
    plans = {f"case_{k + 1:04d}": plan for k, plan in enumerate(todo)}
    store = MadeCases(suite, plans)
    on = Workers(processes=suite.processes, workers=suite.workers, scheduler=suite.scheduler)
    jobs = {name: (name, plan) for name, plan in plans.items()}
    run_tasks(
        _one, None, list(plans), jobs.__getitem__, store, on=on, sources=SOURCES, progress=_say
    )
    print()
    whole = {"seed": suite.seed, "cases": store.keys()}
    with whole_file(suite.keys / "keys.json") as made:
        made.write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")


def _say(what: str, done: int, total: int) -> None:
    print(f"\r{done}/{total} cases", end="", flush=True)


def _one(_: None, job: tuple[str, CasePlan]) -> Made:
    """Make a case in a folder of its own; whoever asked writes its files where they belong."""
    name, plan = job
    with TemporaryDirectory() as folder:
        root = Path(folder)
        key = make_case(plan, root / name)
        paths = [path for path in root.rglob("*") if path.is_file()]
        return Made(key, {p.relative_to(root).as_posix(): p.read_bytes() for p in paths})


if __name__ == "__main__":
    make(tyro.cli(Suite))
