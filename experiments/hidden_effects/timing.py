"""Times one diagnosis: four recordings of 20 s at 1 kHz on `bench`, the whole catalogue.

`python -m experiments.hidden_effects.timing`; the effect hidden is viscous friction, or `--effect`.
With `--effect creep --exclude creep` the catalogue lacks it, and the diagnosis has to abstain.
"""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import tyro
from rich.console import Console

from experiments.hidden_effects import excitation
from experiments.hidden_effects.case import noisy_recording
from experiments.hidden_effects.hidden import EFFECTS
from experiments.hidden_effects.references import ReferenceBench
from tendon_mj.cli import progress_bar
from tendon_mj.lab.diagnosis import diagnose
from tendon_mj.lab.recordings import Recording

DURATION, RATE = 20.0, 1000.0
SCALE = 0.8  # of the drive, so that the tendon stays taut
NOISE = 0.005  # of range
KINDS = (excitation.triangle, excitation.sine, excitation.steps, excitation.loops)


def recordings(effect: str, seed: int) -> list[Recording]:
    """Four recordings of the reference with an effect at a tenth of its range."""
    rng = np.random.default_rng(seed)
    hidden = EFFECTS[effect](rng)
    bench = hidden.apply(ReferenceBench(friction=0.18, rate=RATE), hidden.start)
    description = bench.description
    drives = [SCALE * kind(rng, excitation.clock(DURATION, RATE)) for kind in KINDS]
    readings = bench.simulate(drives)
    noise = NOISE * np.ptp(np.concatenate(readings, axis=1), axis=1)
    stated = {p: description.ranges[n] for n, ps in description.uncertain.items() for p in ps}
    return [
        dataclasses.replace(
            noisy_recording(bench, "bench", rng, kind.__name__, drive, reading, noise),
            known=description.known,
            uncertain=stated,
        )
        for kind, drive, reading in zip(KINDS, drives, readings, strict=True)
    ]


def main(effect: str = "viscous_friction", exclude: tuple[str, ...] = (), seed: int = 1) -> None:
    """Make the recordings, diagnose them, and print how long the diagnosis took.

    Args:
        effect: of the transmission or a sensor, to hide.
        exclude: effects that the catalogue is to lack.
        seed: of every random draw.
    """
    train = recordings(effect, seed)
    began = time.perf_counter()
    with progress_bar() as progress:
        diagnosis = diagnose(train, exclude=exclude, progress=progress)
    Console().print(diagnosis.sentence, soft_wrap=True)
    Console().print(f"{time.perf_counter() - began:.1f} s")


if __name__ == "__main__":
    tyro.cli(main)
