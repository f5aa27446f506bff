"""Three descriptions of the file: drive of the carriage, and measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from experiments.positioning_system.measurement import Measurement
from tendon_mj.lab.recordings import Measured, Recording, Uncertain

SOURCE: Final = "EMPS benchmark of Janot, Gautier and Brunot; see experiments/positioning_system"
MODELS: Final = Path(__file__).parent / "model"
MASS: Final = Uncertain(100.0, 80.0, 120.0)  # [kg]
GUIDE: Final = 25e6, 70711.0  # kp [N/m] and kv [N s/m] of motion.xml

NAMES: Final = {
    "force": "force drives, position is measured",
    "servo": "reference drives through the servo, position and force are measured",
    "motion": "measured motion drives, force is measured",
}


def describe(measurement: Measurement) -> dict[str, Recording]:
    """The descriptions by name.

    The noise is the reproducibility from cycle to cycle. The mass is uncertain; nothing is said of
    friction, damping or an offset.
    """
    position, force = measurement.reproducibility()
    stiffness, damping, _ = measurement.servo_gains()
    measured = {
        "position_m": Measured("position", position),
        "motor_force_N": Measured("force", force),
    }
    place, pull = {"position_m": measurement.position}, {"motor_force_N": measurement.force}
    columns = {
        "force": pull | place,
        "servo": {"reference_m": measurement.reference} | place | pull,
        "motion": {"position_ahead_m": _ahead(measurement, GUIDE[1] / GUIDE[0])} | pull,
    }
    gains = {"servo.kp": stiffness, "servo.kv": damping}
    drive = {
        "force": {"motor_force_N": "motor"},
        "servo": {"reference_m": "servo"},
        "motion": {"position_ahead_m": "guide"},
    }
    known = {"servo": gains, "motion": {"guide.kp": GUIDE[0], "guide.kv": GUIDE[1]}}
    samples = slice(
        0, np.searchsorted(measurement.time, measurement.time[-1] - GUIDE[1] / GUIDE[0])
    )
    return {
        name: Recording(
            name=name,
            model=str(MODELS / f"{name}.xml"),
            source=SOURCE,
            time=measurement.time[samples],
            columns={column: series[samples] for column, series in columns[name].items()},
            drive=drive[name],
            measured={c: m for c, m in measured.items() if c in columns[name].keys() - drive[name]},
            known=known.get(name, {}),
            uncertain={"carriage.mass": MASS},
            settle=0.0 if name == "force" else 0.5,
        )
        for name in NAMES
    }


def _ahead(measurement: Measurement, lead: float) -> np.ndarray:
    """(n,) position as it will be a time ``lead`` [s] later, by which the guide trails."""
    time = measurement.time
    return np.interp(time + lead, time, measurement.position)
