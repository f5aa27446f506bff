"""Memory and overhead of a large sweep; `python -m experiments.cluster.sweep_overhead --help`."""

from __future__ import annotations

import json
import os
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import distributed
import psutil
import tyro

from tendon_mj import load_model
from tendon_mj.lab.sweep import Sweep, motion_recording, run_sweep
from tendon_mj.lab.workers import Workers, local_cluster

_INTERVAL = 2.0  # between two looks at memory [s]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """A sweep of short rollouts of the finger on local workers of Dask.

    Attributes:
        out: folder for the sweep and overhead.json.
        rollouts: number of them.
        steps: of each, of 1 ms.
        workers: of the cluster.
    """

    out: Path
    rollouts: int = 100_000
    steps: int = 30
    workers: int = 2


@dataclass(frozen=True)
class Overhead:
    """Times of a sweep.

    Attributes:
        wall: of the sweep once the workers were there [s].
        tasks: number of them.
        computing: sum of the tasks' times in their workers [s].
        overhead: part of the workers' time in which they did no task [-].
        client_share: part of all processor time that client and scheduler took [-].
        memory: of client and scheduler, and of the largest worker, over time [(s, MB, MB)].
        load: mean number of processes that wanted a core in the last minute of it.
    """

    wall: float
    tasks: int
    computing: float
    overhead: float
    client_share: float
    memory: list[tuple[float, float, float]]
    load: float


def measure(settings: Settings) -> Overhead:
    """Run the sweep, and look at its processes meanwhile."""
    model = load_model("finger")
    recording = motion_recording("finger", model, "curl", settings.steps * 1e-3)
    parameters = ["*.friction=0.05:0.3", "mcp.damping=0.002:0.008", "*.pretension=2:8"]
    outputs = ["flexor_output_tension.max", "flexor_input_tension.max", "tip_force.max"]
    sweep = Sweep(
        model, recording, parameters, draws=settings.rollouts, outputs=outputs, settle=0.0
    )
    with (
        local_cluster(settings.workers) as scheduler,
        distributed.Client(scheduler) as client,
        distributed.get_task_stream(client) as stream,
    ):
        me = psutil.Process()
        memory, ended = list[tuple[float, float, float]](), threading.Event()
        watch = threading.Thread(target=_watch, args=(me, memory, ended))
        before, begun = _processor(me), time.monotonic()
        watch.start()
        run_sweep(sweep, settings.out, on=Workers(scheduler=scheduler), again=True)
        wall = time.monotonic() - begun
        mine, theirs = (b - a for a, b in zip(before, _processor(me), strict=True))
        ended.set()
        watch.join()
    tasks = [
        part["stop"] - part["start"]
        for task in stream.data
        if task["key"].startswith("_run")
        for part in task["startstops"]
        if part["action"] == "compute"
    ]
    return Overhead(
        wall=wall,
        tasks=len(tasks),
        computing=sum(tasks),
        overhead=1.0 - sum(tasks) / (settings.workers * wall),
        client_share=mine / (mine + theirs),
        memory=memory,
        load=os.getloadavg()[0],
    )


def _processor(me: psutil.Process) -> tuple[float, float]:
    """Processor time of this process, and of its children [s]."""
    spent = [p.cpu_times() for p in (me, *me.children())]
    first, *others = (t.user + t.system for t in spent)
    return first, sum(others)


def _watch(
    me: psutil.Process, memory: list[tuple[float, float, float]], ended: threading.Event
) -> None:
    begun = time.monotonic()
    while not ended.wait(_INTERVAL):
        largest = max((p.memory_info().rss for p in me.children()), default=0)
        memory.append((time.monotonic() - begun, me.memory_info().rss / 1e6, largest / 1e6))


if __name__ == "__main__":
    chosen = tyro.cli(Settings)
    found = measure(chosen)
    (chosen.out / "overhead.json").write_text(json.dumps(asdict(found)) + "\n", encoding="utf-8")
    third = len(found.memory) // 3
    print(
        f"{chosen.rollouts} rollouts of {chosen.steps} steps in {found.tasks} tasks: "
        f"{found.wall:.0f} s, overhead {found.overhead:.1%}, client and scheduler "
        f"{found.client_share:.1%} of the processor time; memory of client and largest worker "
        f"after a third {found.memory[third][1:]} MB, at the end {found.memory[-1][1:]} MB; "
        f"load {found.load:.1f}"
    )
