"""A fleet that takes seconds: short recordings of a coarse bench, simulated by the model itself."""

import dataclasses
from datetime import date, timedelta
from pathlib import Path

import numpy as np

from tendon_mj.lab.recordings import Session, Uncertain, write_recording
from tendon_mj.lab.replay import Simulator
from tendon_mj.models import Bench, build_bench
from tests.lab.recorded import recorded

DAYS = 7
FIRST = date(2026, 3, 1)
CHANGED, SINCE = "hand_2", 4  # which rig, and its first recording with the change
ODD = 2  # recording of a rig that is unlike its others
BEFORE, AFTER = 0.15, 0.24  # friction of that one
NOISE = 0.05  # [N]
UNCERTAIN = {
    "sheath.friction": Uncertain(0.15, 0.05, 0.4),
    "sheath.pretension": Uncertain(20.0, 15.0, 25.0),
}


def write_fleet(folder: Path, rigs: int = 3, zero: float = 0.0, odd: str = "") -> None:
    """Write rigs of which one changes its friction, with one description for all.

    Args:
        folder: of the fleet.
        rigs: number of them.
        zero: standard deviation of a sensor's zero, set anew each day [N].
        odd: rig with far more friction on its day `ODD` alone.
    """
    rng = np.random.default_rng(3)
    folder.mkdir(parents=True, exist_ok=True)
    model = build_bench(Bench(guides=4, timestep=2e-3))
    (folder / "bench.xml").write_text(model.to_xml() if model.compile() else "", encoding="utf-8")
    time = np.arange(0.0, 0.8, 0.01)
    drive = 1e-3 * np.sin(2.0 * np.pi * 1.5 * time)
    bare = recorded(
        time,
        {"reel_m": ("reel", drive)},
        {"input_N": ("input_tension", NOISE), "output_N": ("output_tension", NOISE)},
        folder / "bench.xml",
        name="any",
        uncertain=UNCERTAIN,
        session={"input_tension.offset": Session(0.0, zero)} if zero else {},
    )
    simulate = Simulator([bare], threads=1)
    for k in range(rigs):
        rig = folder / f"hand_{k + 1}"
        rig.mkdir()
        own = {"sheath.pretension": 20.0 + 0.3 * k}
        for day in range(DAYS):
            changed = rig.name == CHANGED and day >= SINCE
            friction = (AFTER if changed else BEFORE) * (1.0 + rng.normal(0.0, 0.01))
            friction *= 2.5 if (rig.name, day) == (odd, ODD) else 1.0
            (answer,) = simulate([{**own, "sheath.friction": friction}])[0]
            answer["input_N"] = answer["input_N"] + rng.normal(0.0, zero)
            noisy = {c: v + rng.normal(0.0, NOISE, v.size) for c, v in answer.items()}
            one = dataclasses.replace(
                bare, model="bench.xml", columns={"reel_m": drive, **noisy}, name="any"
            )
            path = write_recording(one, rig / f"{FIRST + timedelta(days=day)}")
            path.with_suffix(".toml").replace(folder / "description.toml")
