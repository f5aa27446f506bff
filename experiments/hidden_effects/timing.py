"""Times one diagnosis: four recordings of 20 s at 1 kHz on `bench`, the whole catalogue.

`python -m experiments.hidden_effects.timing`; the twin hides viscous friction, or `--effect`.
"""

from __future__ import annotations

import dataclasses
import time
from functools import partial

import numpy as np
import tyro
from rich.console import Console

from experiments.hidden_effects import catalogue, excitation
from experiments.hidden_effects.rig import COLUMNS, Rig
from tendon_mj.cli.output import progress_bar
from tendon_mj.diagnosis import diagnose
from tendon_mj.simulate.recording import Measured, Recording
from tendon_mj.simulate.simulator import Simulator

DURATION, RATE = 20.0, 1000.0
NOISE = 0.05  # N
KINDS = (excitation.triangle, excitation.sine, excitation.steps, excitation.loops)


def record(rig: Rig, name: str, drive: np.ndarray, rng: np.random.Generator) -> Recording:
    """A recording of the twin; its reading is linear between the suite's samples."""
    sparse = np.arange(0.0, DURATION, 1.0 / excitation.RATE)
    dense = np.arange(0.0, DURATION, 1.0 / RATE)
    slow = rig.run([np.interp(sparse, dense, drive)])[0]
    readings = {c: np.interp(dense, sparse, r) for c, r in zip(COLUMNS, slow, strict=True)}
    return Recording(
        name=name,
        model="bench",
        source="made by tendon-mj, not measured: experiments/hidden_effects; Apache-2.0",
        time=np.round(dense, 6),
        columns={"input_displacement_m": drive}
        | {c: r + rng.normal(0.0, NOISE, r.size) for c, r in readings.items()},
        drive={"input_displacement_m": "reel"},
        measured={c: Measured(c.removesuffix("_N"), NOISE) for c in COLUMNS},
        known=rig.side.known,
        uncertain={f"sheath.{number}": guess for number, guess in rig.side.ranges.items()},
    )


def main(effect: str = "viscous_friction", timestep: float = 1e-3, seed: int = 1) -> None:
    """Make the recordings, diagnose them, and print how long the diagnosis took.

    Args:
        effect: of the transmission, to hide.
        timestep: longest step of the simulation [s].
        seed: of everything.
    """
    rng = np.random.default_rng(seed)
    hidden = catalogue.EFFECTS[effect](rng)
    rig = hidden.apply(dataclasses.replace(Rig(), friction=0.18), hidden.start)
    dense = np.arange(0.0, DURATION, 1.0 / RATE)
    train = [record(rig, kind.__name__, 0.8 * kind(rng, dense), rng) for kind in KINDS]
    began = time.perf_counter()
    with progress_bar() as progress:
        found = diagnose(train, (), partial(Simulator, timestep=timestep), progress=progress)
    Console().print(found.sentence, soft_wrap=True)
    Console().print(f"{time.perf_counter() - began:.1f} s")


if __name__ == "__main__":
    tyro.cli(main)
