"""Makes a hidden fleet; `python -m experiments.fleet.make_fleet --help`.

The truth is the independent reference of the bench, finer than the model that explains it.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from numpy.typing import NDArray

from experiments.command import run_experiment
from experiments.fleet.changing_rig import KINDS, RigChange, draw_change
from experiments.hidden_effects import excitation
from experiments.hidden_effects.case import noisy_recording
from experiments.hidden_effects.references import COLUMNS, ReferenceBench
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.recordings import Recording, Uncertain, write_recording
from tendon_mj.lab.workers import Workers, run_tasks

FIRST_DAY = datetime(2026, 3, 1)
NOISE = 0.002  # over the range of each column [-]
# standard deviations between rigs, and from day to day [shares]; of a sensor's zero [noise]
BETWEEN = {"friction": 0.1, "pretension": 0.03, "axial_stiffness": 0.03}
DAILY = {"friction": 0.015, "pretension": 0.005}
DAILY_ZERO = 0.5
STATED = {
    "friction": Uncertain(0.15, 0.03, 0.5),
    "pretension": Uncertain(20.0, 12.0, 28.0),
    "axial_stiffness": Uncertain(20000.0, 10000.0, 30000.0),
}
KNOWN = ("environment.stiffness", "sensor.stiffness")
_MADE = ".made"  # in the folder of a rig that is whole


@dataclass(frozen=True, kw_only=True)
class Settings:
    """A hidden fleet.

    Attributes:
        out: folder of the fleet, with a folder for each rig.
        key: file that says which rigs change, in what, and since when.
        seed: of every random draw.
        rigs: number of them.
        changing: how many of these change, each in a kind of its own.
        recordings: of each rig, one a day at most; at least 8.
        processes: of this machine.
    """

    out: Path
    key: Path
    seed: int = 1
    rigs: int = 50
    changing: int = 5
    recordings: int = 12
    processes: int | None = None


@dataclass(frozen=True)
class Plan:
    """A rig: seed of its draws, days of its recordings, its change if any, and the drive [m]."""

    seed: tuple[int, ...]
    days: tuple[int, ...]
    change: RigChange | None
    drive: NDArray[np.float64]


class _Written:
    """Keeps the recordings of each rig; those that are there are not made again.

    Args:
        folder: of the fleet.
        of: composition of the rigs; a folder has those of one.

    Raises:
        InvalidValueError: the folder has rigs of other settings.
    """

    def __init__(self, folder: Path, of: Mapping[str, int]) -> None:
        self._folder, self._of = folder, json.dumps(of)
        for made in sorted(folder.glob(f"*/{_MADE}")):
            if (there := made.read_text(encoding="utf-8")) != self._of:
                raise InvalidValueError(
                    f"{made.parent} was made with {there or 'an older version'}, and {self._of} is"
                    " asked for; give another --out"
                )

    def done(self) -> set[str]:
        return {p.parent.name for p in self._folder.glob(f"*/{_MADE}")}

    def write(self, key: str, result: dict[str, Any]) -> None:
        folder = self._folder / key
        folder.mkdir(parents=True, exist_ok=True)
        for recording in result["recordings"]:
            write_recording(recording, folder / recording.name)
        (folder / _MADE).write_text(self._of, encoding="utf-8")


def make_fleet(settings: Annotated[Settings, tyro.conf.arg(name="")]) -> None:
    """Write the recordings of every rig, and the key.

    Args:
        settings: of the fleet.

    Raises:
        InvalidValueError: the folder has a fleet of other settings.
    """
    made_of = {name: getattr(settings, name) for name in ("seed", "rigs", "changing", "recordings")}
    written = _Written(settings.out, made_of)
    rng = np.random.default_rng(settings.seed)
    drive = draw_drive(rng)
    names = [f"finger_{k + 1:02d}" for k in range(settings.rigs)]
    changing = rng.choice(settings.rigs, settings.changing, replace=False)
    kinds = rng.permutation(list(KINDS))[: settings.changing]
    changes = {
        names[rig]: draw_change(str(kind), settings.recordings, rng)
        for rig, kind in zip(changing, kinds, strict=False)
    }
    plans = {}
    for k, name in enumerate(names):
        gaps = rng.choice([1, 1, 1, 2], settings.recordings - 1)  # a day without now and then
        days = (0, *np.cumsum(gaps).tolist())
        plans[name] = Plan((settings.seed, k), days, changes.get(name), drive)
    run_tasks(
        _make,
        None,
        names,
        plans.__getitem__,
        written,
        on=Workers(processes=settings.processes),
        sources=("tendon_mj", "experiments"),
        progress=lambda what, done, total: print(f"\r{done}/{total} rigs", end="", flush=True),
    )
    print()
    key = {
        name: {
            **dataclasses.asdict(change),
            "parameter": KINDS[change.kind].parameter,
            "since": _date(plans[name].days[change.first]).isoformat(),
        }
        for name, change in changes.items()
    }
    settings.key.parent.mkdir(parents=True, exist_ok=True)
    settings.key.write_text(json.dumps(key, indent=1) + "\n", encoding="utf-8")


def _date(day: int) -> datetime:
    return FIRST_DAY + timedelta(days=day)


def _make(_: None, plan: Plan) -> dict[str, Any]:
    return {"recordings": record(plan)}


def draw_drive(rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw the displacement of the reel in a recording of 5 s [m]."""
    return 0.85 * excitation.held_out(rng, 1.0)[0][: int(5.0 * excitation.RATE)]


def record(plan: Plan) -> list[Recording]:
    """The recordings of a rig, one a day."""
    rng = np.random.default_rng(plan.seed)
    bench = ReferenceBench()
    rig = _scaled(bench, {name: rng.normal(0.0, sd) for name, sd in BETWEEN.items()})
    readings = []
    for k in range(len(plan.days)):
        today = _scaled(rig, {name: rng.normal(0.0, sd) for name, sd in DAILY.items()})
        if plan.change:
            today = plan.change.applied(today, k, len(plan.days))
        readings.append(today.simulate([plan.drive], fine=False)[0])
    noise = NOISE * np.ptp(readings[0], axis=1)
    stated = ReferenceBench.description
    recordings = []
    for day, reading in zip(plan.days, readings, strict=True):
        zeros = rng.normal(0.0, DAILY_ZERO, len(COLUMNS)) * noise
        bare = noisy_recording(
            rig, "bench", rng, f"{_date(day):%Y-%m-%d}", plan.drive, reading + zeros[:, None], noise
        )
        recordings.append(
            dataclasses.replace(
                bare,
                known={name: stated.known[name] for name in KNOWN},
                uncertain={f"sheath.{name}": span for name, span in STATED.items()},
            )
        )
    return recordings


def _scaled(rig: ReferenceBench, shares: dict[str, float]) -> ReferenceBench:
    changed = {name: getattr(rig, name) * (1.0 + share) for name, share in shares.items()}
    return dataclasses.replace(rig, **changed)


if __name__ == "__main__":
    sys.exit(run_experiment(make_fleet, "fleet.make_fleet"))
