"""Recordings of the models of the package, whose readings are 0 until they are simulated."""

from __future__ import annotations

import numpy as np

from tendon_mj.lab.recordings import Measured, Recording

TENSION = "output_tension_N"
MEASURED = {
    "joint_rad": Measured("joint_angle"),
    "tension_1_N": Measured("input_tension_1"),
    "tension_2_N": Measured("input_tension_2"),
}


def wave(time):
    return 0.8 * np.sin(3.0 * time) + 0.2 * np.sin(11.0 * time)


def joint_recording(time=None, drive=None, **more):
    """A recording to drive the joint with; what it measured is 0."""
    time = np.arange(0.0, 1.0, 0.02) if time is None else np.asarray(time)
    columns = {"command_rad": wave(time) if drive is None else drive}
    columns |= {column: np.zeros(len(time)) for column in MEASURED}
    return Recording(
        **{
            "name": "made up",
            "model": "joint",
            "source": "made up",
            "time": time,
            "columns": columns,
            "drive": {"command_rad": "command"},
            "measured": MEASURED,
        }
        | more
    )


def bench_recording(duration=0.2, rate=20.0, name="pull", **more):
    time = np.arange(0.0, duration, 0.002)
    columns = {
        "input_displacement_m": 1e-3 * np.sin(rate * time) + 2e-4,
        "input_tension_N": 0.0 * time,
        "output_tension_N": 0.0 * time,
    }
    return Recording(
        **{
            "name": name,
            "model": "bench",
            "source": "made up",
            "time": time,
            "columns": columns,
            "drive": {"input_displacement_m": "reel"},
            "measured": {
                "input_tension_N": Measured("input_tension"),
                "output_tension_N": Measured("output_tension"),
            },
        }
        | more
    )


def bench(name: str, **changed: object) -> Recording:
    """Half a second of the bench."""
    time = np.arange(0.0, 0.5, 0.01)
    return Recording(
        **{
            "name": name,
            "model": "bench",
            "source": "a test",
            "time": time,
            "columns": {
                "input_displacement_m": 5e-4 * np.sin(12.0 * time),
                TENSION: np.zeros(time.size),
            },
            "drive": {"input_displacement_m": "reel"},
            "measured": {TENSION: Measured("output_tension")},
            **changed,
        }
    )
