"""Workers and clients killed at random moments; `python -m experiments.cluster.kills --help`."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil
import tyro
from numpy.typing import NDArray

from tendon_mj.lab.parquet_parts import ParquetParts
from tendon_mj.lab.workers import Workers, local_cluster, run_tasks

_WORKERS = 2
_LONGEST = 0.2  # of a task [s]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Tasks that log their completion, run on two workers that are killed, by clients that are.

    Attributes:
        out: folder for results and logs.
        tasks: number of them.
        kills: of workers, then of clients.
        seed: of the moments.
    """

    out: Path
    tasks: int = 400
    kills: int = 10
    seed: int = 1


def logged(folder: str, task: int) -> dict[str, NDArray[np.int64]]:
    """Take a while, log the completion, and return a table of one row."""
    time.sleep(random.Random(task).uniform(0.5, 1.0) * _LONGEST)
    with Path(folder, "completed").open("a") as log:
        log.write(f"{task}\n")
    return {"task": np.array([task])}


def run_client(folder: Path, tasks: int, scheduler: str) -> None:
    """Do the tasks that have no result yet."""
    numbers = {f"task_{k:04d}": k for k in range(tasks)}
    store = ParquetParts(folder / "results")
    on = Workers(scheduler=scheduler)
    sources = ("tendon_mj", "experiments")
    run_tasks(
        logged, str(folder), list(numbers), numbers.__getitem__, store, on=on, sources=sources
    )


def kill_workers(folder: Path, settings: Settings, scheduler: str) -> None:
    """Kill workers while one client runs."""
    draw = random.Random(settings.seed)
    client = threading.Thread(target=run_client, args=(folder, settings.tasks, scheduler))
    client.start()
    for _ in range(settings.kills):
        results = len(list((folder / "results").glob("task_*")))
        while client.is_alive() and len(list((folder / "results").glob("task_*"))) < results + 5:
            time.sleep(0.01)
        time.sleep(draw.uniform(0.0, 2.0 * _LONGEST))
        workers = [p for p in psutil.Process().children() if "spawn_main" in " ".join(p.cmdline())]
        os.kill(draw.choice(workers).pid, signal.SIGKILL)
    client.join()


def kill_clients(folder: Path, settings: Settings, scheduler: str) -> None:
    """Kill one client after the other, and let the last one end."""
    draw = random.Random(settings.seed)
    command = [sys.executable, "-m", "experiments.cluster.kills", "client"]
    command += [str(folder), str(settings.tasks), scheduler]
    for _ in range(settings.kills):
        results = len(list((folder / "results").glob("task_*")))
        client = subprocess.Popen(command)
        while len(list((folder / "results").glob("task_*"))) < results + 5:
            time.sleep(0.01)
        time.sleep(draw.uniform(0.0, 2.0 * _LONGEST))
        client.kill()
        client.wait()
    subprocess.run(command, check=True)


def counted(folder: Path, tasks: int) -> dict[str, object]:
    """Finished parts, and how often each was computed."""
    result = ParquetParts(folder / "results").read()["task"].tolist()
    completed = Counter(map(int, (folder / "completed").read_text().split()))
    return {
        "tasks": tasks,
        "lost": sorted(set(range(tasks)) - set(result)),
        "twice in the table": [task for task, count in Counter(result).items() if count > 1],
        "computed more than once": sum(completed.values()) - tasks,
        "most often": max(completed.values()),
    }


def main(settings: Settings) -> None:
    """Try both, and print the results."""
    said: dict[str, object] = {"kills": settings.kills, "workers": _WORKERS}
    with local_cluster(_WORKERS) as scheduler:
        for trial in (kill_workers, kill_clients):
            folder = settings.out.resolve() / trial.__name__
            folder.mkdir(parents=True, exist_ok=True)
            trial(folder, settings, scheduler)
            said[trial.__name__] = counted(folder, settings.tasks)
            print(trial.__name__, said[trial.__name__], flush=True)
    text = json.dumps(said, indent=1) + "\n"
    (settings.out / "kills.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:2] == ["client"]:
        run_client(Path(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
    else:
        main(tyro.cli(Settings))
