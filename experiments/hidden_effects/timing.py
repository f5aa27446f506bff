"""Times diagnoses of `bench`, with all effects: `python -m experiments.hidden_effects.timing`.

Twelve rigs have a strong effect and, beside it, something weak that no catalogue lists, in three
recordings of 20 s at 500 Hz. `--beside none` hides the effect alone, `--count 4 --rate 1000`
records more, and with `--effects creep --exclude creep` a diagnosis has to abstain. Other programs
disturb the seconds, but not the number of steps.
"""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import tyro

from experiments.hidden_effects import excitation
from experiments.hidden_effects.case import noisy_recording
from experiments.hidden_effects.hidden import EFFECTS
from experiments.hidden_effects.references import ReferenceBench
from experiments.hidden_effects.strengths import find_strength, rms
from tendon_mj.lab.diagnosis import diagnose
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import FloatArray

SCALE = 0.8  # of the drive, so that the tendon stays taut
NOISE = 0.005  # of range
STRONG, WEAK = 12.0, 1.5  # change by the effect, and by what is unlisted [noise, rms]
KINDS = (excitation.triangle, excitation.sine, excitation.steps, excitation.loops)
MIXED = {
    "viscous_friction": "crosstalk",
    "constant_friction": "hum",
    "backlash": "crosstalk",
    "stiffening": "runout",
    "creep": "crosstalk",
    "sheath_compliance": "wander",
    "direction_asymmetry": "hum",
    "position_dependent_friction": "crosstalk",
    "friction_drift": "runout",
    "sensor_lag": "wander",
    "sensor_gain": "runout",
    "velocity_weakening": "crosstalk",
}


def unlisted(
    what: str, rng: np.random.Generator, now: FloatArray, drive: FloatArray, readings: FloatArray
) -> FloatArray:
    """(2, n) change of readings by something that no catalogue lists, in any size."""
    change = np.zeros_like(readings)
    if what == "crosstalk":  # of the input's amplifier into the output's
        change[1] = readings[0] - readings[0].mean()
    elif what == "hum":
        change[1] = np.sin(2.0 * np.pi * rng.uniform(10.0, 60.0) * now)
    elif what == "runout":  # of the drum
        change[0] = np.sin(2.0 * np.pi * drive / 0.7e-3 + rng.uniform(0.0, 6.0))
    elif what == "wander":  # of a zero
        change[0] = sum(np.sin(rng.uniform(0.5, 3.0) * now + rng.uniform(0.0, 6.0)) for _ in "123")
    return change


def recordings(
    effect: str, beside: str, seed: int, count: int, duration: float, rate: float
) -> list[Recording]:
    """Recordings of the reference with an effect, and something weak beside it."""
    rng = np.random.default_rng(seed)
    hidden, plain = EFFECTS[effect](rng), ReferenceBench(friction=0.18, rate=rate)
    description, now = plain.description, excitation.clock(duration, rate)
    drives = [SCALE * KINDS[k](rng, now) for k in range(count)]
    without = np.concatenate(plain.simulate(drives, fine=False), axis=1)
    noise = NOISE * np.ptp(without, axis=1)

    def change(strength: float) -> float:
        given = hidden.apply(plain, strength).simulate(drives, fine=False)
        return rms((np.concatenate(given, axis=1) - without) / noise[:, None])

    found = find_strength(change, STRONG, hidden.low, hidden.high, hidden.start)
    readings = hidden.apply(plain, found.strength).simulate(drives)
    changes = [unlisted(beside, rng, now, *pair) for pair in zip(drives, readings, strict=True)]
    left = rms(np.concatenate(changes, axis=1) / noise[:, None])
    stated = {p: description.ranges[n] for n, ps in description.uncertain.items() for p in ps}
    return [
        dataclasses.replace(
            noisy_recording(
                plain, "bench", rng, f"r{k}", drive, reading + WEAK / (left or 1.0) * change, noise
            ),
            known=description.known,
            uncertain=stated,
        )
        for k, (drive, reading, change) in enumerate(zip(drives, readings, changes, strict=True))
    ]


class Counting(Simulator):
    """Simulator that counts the steps of its simulations."""

    done = 0

    def _run_all(self, jobs):  # type: ignore[no-untyped-def]
        type(self).done += sum(self._schedules[job.recording].steps for job in jobs)
        return super()._run_all(jobs)


def main(
    effects: Sequence[str] = tuple(MIXED),
    beside: str = "",
    exclude: tuple[str, ...] = (),
    seed: int = 1,
    count: int = 3,
    duration: float = 20.0,
    rate: float = 500.0,
    out: Path | None = None,
) -> None:
    """Make recordings, diagnose them, and print how long that took.

    Args:
        effects: of the transmission or a sensor, to hide, each in a rig of its own.
        beside: crosstalk, hum, runout, wander or none; default: one for each effect.
        exclude: effects that the catalogue is to lack.
        seed: of every random draw.
        count: of recordings, at most 4.
        duration: of each [s].
        rate: of samples [1/s].
        out: folder for the results.
    """
    for effect in effects:
        weak = beside or MIXED.get(effect, "crosstalk")
        train = recordings(effect, weak, seed, count, duration, rate)
        Counting.done, began, used = 0, time.perf_counter(), time.process_time()
        result = diagnose(train, simulator=Counting, exclude=exclude).result()
        seconds, processor = time.perf_counter() - began, time.process_time() - used
        print(
            f"{effect} and {weak}: {result['verdict']} {', '.join(result['effects'])};"
            f" {1e-6 * Counting.done:.0f} million steps, {processor:.0f} s of processor time,"
            f" {seconds:.0f} s",
            flush=True,
        )
        if out:
            out.mkdir(parents=True, exist_ok=True)
            (out / f"{effect}_{weak}.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    tyro.cli(main)
