"""Recordings of the models of the package, whose readings are 0 until they are simulated."""

from __future__ import annotations

import numpy as np

from tendon_mj.lab.recordings import Measured, Recording
from tests.lab.recorded import recorded

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
    return recorded(
        time,
        {"command_rad": ("command", wave(time) if drive is None else drive)},
        {c: m.sensor for c, m in MEASURED.items()},
        "joint",
        **more,
    )


def bench_recording(duration=0.2, rate=20.0, name="pull", **more):
    time = np.arange(0.0, duration, 0.002)
    return recorded(
        time,
        {"input_displacement_m": ("reel", 1e-3 * np.sin(rate * time) + 2e-4)},
        {"input_tension_N": "input_tension", "output_tension_N": "output_tension"},
        name=name,
        **more,
    )


def bench(name: str, **changed: object) -> Recording:
    """Half a second of the bench."""
    time = np.arange(0.0, 0.5, 0.01)
    return recorded(
        time,
        {"input_displacement_m": ("reel", 5e-4 * np.sin(12.0 * time))},
        {TENSION: "output_tension"},
        name=name,
        **changed,
    )
