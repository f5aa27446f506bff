"""`python -m experiments.soak`: long trials of the promises of docs/guarantees.md."""

from __future__ import annotations

import platform
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

from experiments.command import run_experiment
from experiments.hidden_effects.make import Suite, make
from experiments.soak.batches import Outcomes, run_batches
from experiments.soak.killed_runs import killed_runs
from experiments.soak.long_run import long_run
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.models import example_recording, example_rig

_CASES = 4  # of the hidden suite whose diagnosis is killed


def soak(
    out: Path = Path("out/soak"),
    fuzz: int = 20_000,
    commands: int = 5_000,
    lives: int = 4_000,
    bench_steps: int = 100_000_000,
    finger_steps: int = 10_000_000,
    kills: int = 10,
    seed: int = 0,
) -> None:
    """Try hostile models, recordings and commands, long runs, lives of models, and killed runs.

    Takes about two hours on one core. The laws on random tendons are the tests' own:
    TENDON_MJ_EXAMPLES=20000 pytest tests/guarantees.

    Args:
        out: folder for result.json.
        fuzz: number of broken models, and of broken recordings.
        commands: number of command lines.
        lives: number of models that are made, copied, pickled, recompiled and deleted.
        bench_steps: steps of the bench.
        finger_steps: steps of the finger under its servos.
        kills: number of runs of each command that are killed.
        seed: of all that is drawn.
    """
    output = Output(out)
    result: dict[str, object] = {"machine": platform.platform(), "python": sys.version.split()[0]}
    with progress_bar() as progress:
        batches = {
            "model_fuzz": fuzz,
            "recording_fuzz": fuzz,
            "command_fuzz": commands,
            "life_cycle": lives,
        }
        for name, trials in batches.items():
            began = time.perf_counter()
            results = run_batches(f"experiments.soak.{name}", trials, seed, progress=progress)
            result[name] = results.result() | {"seconds": time.perf_counter() - began}
            console.print(f"{name}: {_said(results)}", soft_wrap=True)
        for name, steps in (("bench", bench_steps), ("finger", finger_steps)):
            run = long_run(name, steps, progress)
            result[f"long_run_{name}"] = asdict(run)
            console.print(
                f"{name}, {run.steps} steps in {run.seconds:.0f} s: unstretched length drifts by "
                f"{run.drift:.1e}, memory grows by {run.memory_growth:.1f} MiB, "
                f"{'the same' if run.resumed else 'OTHERWISE'} from checkpoints, "
                f"{run.unsolved:.0f} unsolved",
                soft_wrap=True,
            )
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for job, (command, finished) in _long_jobs(folder).items():
                killed = killed_runs(
                    command, folder / job, kills, seed, finished=finished, progress=progress
                )
                result[f"killed_{job}"] = asdict(killed)
                console.print(
                    f"{job}: {killed.kills} killed, {killed.ended} ended before, "
                    f"{len(killed.broken)} files half-written, {len(killed.repeated)} parts done "
                    f"twice, the last run {killed.failed or 'did it all'}",
                    soft_wrap=True,
                )
    output.result(result)
    output.close()


def _long_jobs(folder: Path) -> dict[str, tuple[list[str], str]]:
    """Modules, their arguments, and the file of a finished part of each."""
    recording, rig, suite = str(example_recording()), example_rig(), folder / "cases"
    train, held_out = str(rig / "triangles.csv"), str(rig / "sines.csv")
    about = ["--description", str(rig / "rig.toml"), "--no-sysid"]
    make(Suite(out=suite, keys=folder / "keys", kinds=("effect",), strengths=(5.0,), cases=_CASES))
    return {
        "replay": (["tendon_mj", "replay", recording], ""),
        "compare": (["tendon_mj", "compare"], ""),
        "diagnose": (["tendon_mj", "diagnose", train, "--hold-out", held_out, *about], ""),
        "suite": (
            ["experiments.hidden_effects.diagnose_suite", "--suite", str(suite)],
            "*/run.json",
        ),
    }


def _said(outcomes: Outcomes) -> str:
    counts = ", ".join(f"{number} {outcome}" for outcome, number in outcomes.counts.items())
    broken = [*outcomes.violations, *outcomes.crashes]
    return (
        f"{counts}; {len(outcomes.violations)} broken promises, {len(outcomes.crashes)} crashes"
        f"{''.join(f'; {what}' for what in broken[:5])}; {outcomes.most_memory:.0f} MiB at most, "
        f"{outcomes.most_growth:.1f} MiB more at most after the second half of a batch"
    )


if __name__ == "__main__":
    sys.exit(run_experiment(soak, "soak"))
