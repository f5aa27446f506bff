"""`python -m experiments.mutation TARGET`: mutants of the solver, the engine or the diagnosis.

Cosmic Ray makes the mutants, runs the tests on each and keeps what came of it, so that a run that
was stopped goes on. Mutants are drawn at random, since the tests of all would take days.
"""

from __future__ import annotations

import os
import random
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Literal

import tomli_w
import tyro
from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import MutationSpec, TestOutcome, WorkerOutcome, WorkItem, WorkResult

from experiments.mutation.targets import TARGETS, Target

# A decorator only compiles, and `|` stands in annotations, which nothing evaluates.
_LEFT_OUT = "core/RemoveDecorator", "core/ReplaceBinaryOperator_BitOr"


def mutate(
    target: Literal["sheath", "engine", "diagnosis"],
    /,
    sample: int = 100,
    seed: int = 1,
    out: Path = Path("out/mutation"),
) -> None:
    """Run the tests on mutants of a part of the package as it was last committed.

    Args:
        target: the part.
        sample: number of mutants, drawn at random.
        seed: of the draw.
        out: folder for a clone, the session, and the list of survivors.
    """
    chosen, folder = TARGETS[target], (out / f"{target}_{seed}").resolve()
    clone, session = folder / "clone", folder / "session.sqlite"
    if not clone.exists():
        subprocess.run(["git", "clone", "--quiet", ".", clone], check=True)
    config = folder / "cosmic-ray.toml"
    config.write_text(tomli_w.dumps({"cosmic-ray": _configuration(chosen)}))
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    own = {"PYTHONPATH": str(clone), "PATH": path}
    environment = {**os.environ, **own}

    def cosmic_ray(command: str, *arguments: str | Path) -> None:
        words = [sys.executable, "-m", "cosmic_ray.cli", command, *arguments]
        subprocess.run(words, cwd=clone, env=environment, check=True)

    if not session.exists():
        cosmic_ray("baseline", config)
        cosmic_ray("init", config, session)
        with use_db(session, WorkDB.Mode.open) as db:
            _draw(db, sample, seed)
    cosmic_ray("exec", config, session)
    with use_db(session, WorkDB.Mode.open) as db:
        text = _report(db)
    (folder / "survivors.md").write_text(text)
    print(text)


def _configuration(target: Target) -> dict[str, object]:
    """What Cosmic Ray reads."""
    return {
        "module-path": [str(module) for module in target.modules],
        "timeout": target.timeout,
        "excluded-modules": [],
        "test-command": f"sh -c {shlex.quote(target.tests)}",
        "distributor": {"name": "local"},
    }


def _draw(db: WorkDB, sample: int, seed: int) -> None:
    """Leave a sample of the mutants to be tested."""
    wanted = sorted(
        (item for item in db.work_items if not _mutation(item).operator_name.startswith(_LEFT_OUT)),
        key=lambda item: _key(_mutation(item)),
    )
    drawn = {item.job_id for item in random.Random(seed).sample(wanted, min(sample, len(wanted)))}
    rest = [item.job_id for item in db.work_items if item.job_id not in drawn]
    db.set_multiple_results(rest, WorkResult(worker_outcome=WorkerOutcome.SKIPPED))
    print(f"{len(drawn)} of {len(wanted)} mutants")


def _mutation(item: WorkItem) -> MutationSpec:
    """The one mutation of a mutant."""
    (mutation,) = item.mutations
    return mutation


def _key(mutation: MutationSpec) -> tuple[str, str, int]:
    """What distinguishes a mutation, the same in every session."""
    return str(mutation.module_path), mutation.operator_name, mutation.occurrence


def _report(db: WorkDB) -> str:
    """How many mutants were killed, and the changes of those that were not."""
    skipped = WorkerOutcome.SKIPPED
    tried = {job: result for job, result in db.results if result.worker_outcome != skipped}
    survived = {j: r for j, r in tried.items() if r.test_outcome == TestOutcome.SURVIVED}
    killed = len(tried) - len(survived)
    lines = [f"{killed} of {len(tried)} mutants killed ({killed / max(len(tried), 1):.0%}).", ""]
    for item in sorted(db.work_items, key=lambda item: _key(_mutation(item))):
        if item.job_id in survived:
            diff = survived[item.job_id].diff or ""
            lines += ["```diff", *diff.splitlines()[2:], "```", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    tyro.cli(mutate)
