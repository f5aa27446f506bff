"""A rig that was made up: the joint's model with friction in its sheath, driven faster."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from experiments.measured_joint.recording import COLUMNS, COMMAND, DESCRIPTION, describe
from experiments.measured_joint.wound_in import WoundIn
from tendon_mj import Measured
from tendon_mj.lab.recordings import Recording, Uncertain

FRICTION = 0.22
PLANTED = {
    "command.command_scale": 1.6,
    "joint.stiffness": 0.03,
    "joint.frictionloss": 0.015,
    **{f"sheath_{k}.axial_stiffness": 900.0 for k in (1, 2)},
    **{f"sheath_{k}.friction": FRICTION for k in (1, 2)},
}
UNCERTAIN = {
    "command.command_scale": Uncertain(1.4, 0.5, 4.0),
    "sheath_*.axial_stiffness": Uncertain(1000.0, 100.0, 4000.0),
    "joint.frictionloss": Uncertain(0.01, 0.0, 0.1),
}
_NOISE = {"joint_rad": 0.005, "tension_1_N": 0.05, "tension_2_N": 0.05}


def blank(degrees, samples=70):
    """A recording of the command alone; both load cells read 5 N."""
    time = 0.025 * np.arange(samples)
    command = math.radians(60.0) * np.sin(4.5 * time)
    columns = {COMMAND: command, **{c: np.full(samples, 5.0) for c in COLUMNS}}
    columns["joint_rad"] = np.zeros(samples)
    plain = Recording(
        name=f"bend_{degrees:03d}deg",
        model=str(DESCRIPTION.with_name("joint.xml")),
        source="made up",
        time=time,
        columns=columns,
        drive={COMMAND: "command"},
        measured={
            "joint_rad": Measured("joint_angle", _NOISE["joint_rad"]),
            "tension_1_N": Measured("input_tension_1", _NOISE["tension_1_N"]),
            "tension_2_N": Measured("input_tension_2", _NOISE["tension_2_N"]),
        },
        uncertain=UNCERTAIN,
    )
    return describe(plain, math.radians(degrees))


def rig(bends, planted=PLANTED, seed=0, samples=70):
    """Recordings of the rig, with noise but for the first sample."""
    random = np.random.default_rng(seed)
    blanks = [blank(b, samples) for b in bends]
    made = []
    for recording, series in zip(blanks, WoundIn(blanks)([planted])[0], strict=True):
        noise = {c: random.normal(0.0, _NOISE[c], recording.time.size) for c in COLUMNS}
        for one in noise.values():
            one[0] = 0.0
        columns = {**recording.columns, **{c: series[c] + noise[c] for c in COLUMNS}}
        made.append(replace(recording, columns=columns))
    return made
