"""Makes a suite of hidden cases from a seed; `python -m experiments.hidden_effects.make --help`."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro

from experiments.hidden_effects.suite.case import make_case
from experiments.hidden_effects.suite.case_plan import CasePlan, Kind
from experiments.hidden_effects.suite.plan_suite import KINDS, plan_suite
from experiments.worker_processes import worker_processes


@dataclass(frozen=True, kw_only=True)
class Suite:
    """Hidden cases in one folder, and their keys in another.

    Attributes:
        out: folder for the cases.
        keys: folder for keys.json, which only the scorer may read.
        seed: of every random draw.
        kinds: of cases: effect, pair, parameter, nothing, outside, joint; and session, remainder,
            too_high.
        strengths: ratios of the residual after calibration to the noise, with one effect [-].
        noises: standard deviations over the range of the signal [-].
        repeats: of cases with one effect, a wrong parameter or an effect outside the catalogue, and
            of the last three kinds.
        nothing: cases in which nothing is hidden; of sessions a quarter as many.
        pairs: cases with two effects.
        cases: the first so many only; 0 is all.
        processes: number of worker processes.
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
    processes: int = 1


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
    jobs = [(plan, suite.out / f"case_{k + 1:04d}") for k, plan in enumerate(todo)]
    begun, keys = time.monotonic(), {}
    with worker_processes(suite.processes) as pool:
        for (_, folder), key in zip(jobs, pool.map(_one, jobs), strict=True):
            keys[folder.name] = key
            spent = time.monotonic() - begun
            print(f"\r{len(keys)}/{len(jobs)} cases, {spent:.0f} s", end="", flush=True)
    print()
    suite.keys.mkdir(parents=True, exist_ok=True)
    whole = {"seed": suite.seed, "cases": keys}
    (suite.keys / "keys.json").write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")


def _one(job: tuple[CasePlan, Path]) -> dict[str, Any]:
    plan, folder = job
    return make_case(plan, folder)


if __name__ == "__main__":
    make(tyro.cli(Suite))
