"""`python -m experiments.compare_versions OTHER_PYTHON`: step cost of two versions of the package.

Each version runs in a process of its own, which imports the package that its Python has installed.
The two take turns, so that both see the same machine, and each round gives one ratio of CPU times.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from experiments.command import run_experiment
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.errors import InvalidValueError

_MODELS = Path(__file__).parents[1] / "models"

# Runs in either version, so that it uses nothing of the package but its plugins.
_WORKER = """
import sys, time
import mujoco, numpy, tendon_mj
from mujoco import rollout

print("ready", flush=True)
for line in sys.stdin:
    path, steps = line.rsplit(maxsplit=1)
    steps = int(steps)
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    limited = model.actuator_ctrllimited.astype(bool)
    low, high = model.actuator_ctrlrange.T
    centre = numpy.where(limited, 0.5 * (low + high), 0.0)
    swing = numpy.where(limited, 0.1 * (high - low), 1e-3)
    phase = numpy.linspace(0.0, 4.0 * numpy.pi, steps)[:, None]
    controls = centre + swing * numpy.sin(phase)
    everything = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = numpy.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, data, state, everything)
    began = time.process_time()
    rollout.rollout([model], [data], state[None], controls[None], nstep=steps)
    print((time.process_time() - began) / steps, flush=True)
"""


class _Version:
    """A version of the package in a process of its own."""

    def __init__(self, python: Path) -> None:
        try:
            self._process = subprocess.Popen(
                [python, "-c", _WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
        except OSError as error:
            raise InvalidValueError(f"{python}: not a Python interpreter ({error})") from error
        if self._ask() != "ready":
            raise InvalidValueError(f"{python}: has no tendon_mj installed")

    def _ask(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def step_time(self, model: Path, steps: int) -> float:
        """CPU time of a step [s]."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{model} {steps}\n")
        self._process.stdin.flush()
        answer = self._ask()
        if not answer:
            raise InvalidValueError(f"{model}: one of the two versions cannot run it")
        return float(answer)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def compare_versions(
    other_python: Annotated[Path, tyro.conf.Positional],
    out: Path = Path("out/compare_versions"),
    models: tuple[Path, ...] = (_MODELS / "bench/scene.xml", _MODELS / "finger/scene.xml"),
    rounds: int = 500,
    steps: int = 400,
) -> None:
    """Step cost of this version over that of another one, paired.

    Args:
        other_python: Python of an environment in which the other version is installed.
        out: folder for result.json.
        models: that both versions can run.
        rounds: in each of which both run each model, ≥ 1.
        steps: of one run, ≥ 1.
    """
    if rounds < 1 or steps < 1:
        raise InvalidValueError(f"rounds = {rounds} and steps = {steps}: both must be 1 or more")
    output = Output(out)
    this, other = _Version(Path(sys.executable)), _Version(other_python)
    by_name = {}
    with progress_bar() as progress:
        for model in models:
            times = np.empty((rounds, 2))
            for number in range(rounds):
                turn = ((0, this), (1, other)) if number % 2 else ((1, other), (0, this))
                for column, version in turn:
                    times[number, column] = version.step_time(model.absolute(), steps)
                progress(f"step cost, {model.parent.name}", number + 1, rounds)
            ratios = times[:, 0] / times[:, 1]
            low, median, high = np.quantile(ratios, (0.25, 0.5, 0.75))
            name = model.parent.name if model.stem == "scene" else model.stem
            by_name[name] = {
                "ratio": float(median),
                "ratio_of_the_least": float(times[:, 0].min() / times[:, 1].min()),
                "quartiles": [float(low), float(high)],
                "step": float(np.median(times[:, 0])),
                "other_step": float(np.median(times[:, 1])),
            }
            console.print(f"{name}: {json.dumps(by_name[name])}", soft_wrap=True)
    for version in (this, other):
        version.close()
    output.result(by_name)
    output.close()


if __name__ == "__main__":
    sys.exit(run_experiment(compare_versions, "compare_versions"))
