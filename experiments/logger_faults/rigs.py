"""Five rigs that are as their models, motions that drive them, and their readings with noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tendon_mj import Measured, Recording, Uncertain, example_rig, replay_recording
from tendon_mj.typing import FloatArray

RATES = 50.0, 100.0, 200.0  # samples per second
SECONDS = 8.0
REST = 0.6  # before the motion [s]
NOISES = 0.002, 0.008  # of a column's range
ROUNDED = 0.05  # noises, to which the file rounds
STATED = 0.7  # share of the recordings that state their noise
POINTS = 48  # of a recording of settled points

MOTOR = """<mujoco><extension><plugin plugin="tendon_mj.sheath">
<instance name="sheath"><config key="tendon" value="cable"/><config key="friction" value="0.1"/>
<config key="axial_stiffness" value="2000"/><config key="pretension" value="20"/>
<config key="reel_joint" value="spool"/><config key="reel_radius" value="0.01"/></instance>
<instance name="pull"><config key="sensor" value="input_tension"/></instance>
</plugin></extension><option gravity="0 0 0" timestep="0.001"/>
<worldbody><site name="a"/><site name="b" pos="0.1 0 0"/><site name="c" pos="0.1 0.1 0"/>
<body pos="0 0 0.1"><joint name="spool" armature="0.001" damping="0.1"/><geom size="0.01"/></body>
<body pos="0.1 0.2 0"><joint type="slide" name="load" axis="0 1 0" stiffness="4000" damping="100"
 springref="0.005" {limit}/><geom size="0.05" contype="0"/><site name="d"/></body></worldbody>
<tendon><spatial name="cable"><site site="a"/><site site="b"/><site site="c"/><site site="d"/>
</spatial></tendon><actuator><position name="motor" joint="spool" kp="50" kv="1"/></actuator>
<sensor><plugin name="pull" objtype="tendon" objname="cable" instance="pull"/>
<jointpos name="spool" joint="spool"/><jointpos name="load" joint="load"/></sensor></mujoco>"""
STOP = 'range="-0.004 0.0008" limited="true"'

MUSCLE = """<mujoco><extension><plugin plugin="tendon_mj.sheath">
<instance name="sheath"><config key="tendon" value="cable"/><config key="friction" value="0.1"/>
</instance><instance name="pull"><config key="sensor" value="input_tension"/></instance>
</plugin></extension><option gravity="0 0 0"/>
<worldbody><site name="a"/><site name="b" pos="0.1 0 0"/><body pos="0.1 0.2 0"><joint type="slide"
 name="load" axis="0 1 0" stiffness="1500" damping="60"/><geom size="0.05" contype="0"/>
<site name="d"/></body></worldbody>
<tendon><spatial name="cable"><site site="a"/><site site="b"/><site site="d"/></spatial></tendon>
<actuator><muscle name="muscle" tendon="cable" force="30" lengthrange="0.2 0.4"/></actuator>
<sensor><plugin name="pull" objtype="tendon" objname="cable" instance="pull"/>
<jointpos name="load" joint="load"/></sensor></mujoco>"""


@dataclass(frozen=True)
class Rig:
    """A model, its drive, and its measurements.

    Attributes:
        model: a name, or the text of an MJCF file.
        drive: column → (actuator, middle, amplitude) [control].
        measured: column → sensor.
        uncertain: parameter → its description.
        known: parameter → value in its description.
        settle: as in a description [s].
    """

    model: str
    drive: Mapping[str, tuple[str, float, float]]
    measured: Mapping[str, str]
    uncertain: Mapping[str, Uncertain]
    known: Mapping[str, float] = field(default_factory=dict)
    settle: float = 0.5


_MOTOR = Rig(
    model=MOTOR.format(limit=""),
    drive={"command_rad": ("motor", 0.0, 0.35)},
    measured={"cable_N": "pull", "spool_rad": "spool", "load_m": "load"},
    uncertain={"sheath.friction": Uncertain(0.1, 0.03, 0.3)},
    settle=0.0,
)
RIGS: Mapping[str, Rig] = {
    "reel": Rig(
        model=str(example_rig() / "rig.xml"),
        drive={"spool_rad": ("reel", 0.1, 0.6)},
        measured={"cable_N": "input_tension", "lever_rad": "lever_angle"},
        uncertain={
            "sheath.friction": Uncertain(0.12, 0.03, 0.3),
            "sheath.pretension": Uncertain(15.0, 12.0, 18.0),
        },
        known={"reel.command_scale": 0.01},
    ),
    "motor": _MOTOR,
    "muscle": Rig(
        model=MUSCLE,
        drive={"activation_N": ("muscle", 0.5, 0.4)},
        measured={"cable_N": "pull", "load_m": "load"},
        uncertain={"sheath.friction": Uncertain(0.1, 0.03, 0.3)},
    ),
    "two cables": Rig(
        model="joint",
        drive={"command_rad": ("command", 0.0, 0.8)},
        measured={
            "joint_rad": "joint_angle",
            "pull_1_N": "input_tension_1",
            "pull_2_N": "input_tension_2",
        },
        uncertain={"sheath_*.friction": Uncertain(0.19, 0.06, 0.5)},
    ),
    "finger": Rig(
        model="finger",
        drive={
            "flexor_rad": ("flexor_angle", 1.2, 1.0),
            "extensor_rad": ("extensor_angle", -0.8, 0.3),
        },
        measured={
            "mcp_rad": "mcp_angle",
            "motor_rad": "flexor_motor_angle",
            "flexor_N": "flexor_input_tension",
        },
        uncertain={"flexor_sheath.friction": Uncertain(0.1, 0.03, 0.3)},
        settle=0.0,
    ),
}
# of clean recordings: the same rigs where they strike a stop, or stick and slip
CLEAN: Mapping[str, Rig] = {
    **RIGS,
    "motor": replace(_MOTOR, model=MOTOR.format(limit=STOP)),
    "reel": replace(
        RIGS["reel"],
        known={
            **RIGS["reel"].known,
            "sheath.static_friction": 0.25,
            "sheath.stribeck_velocity": 0.002,
        },
    ),
}


def motion(random: np.random.Generator, kind: str) -> tuple[FloatArray, FloatArray]:
    """Time [s] and a motion from −1 to 1, rounded as a file is: one of `MOTIONS`."""
    rate = float(random.choice(RATES))
    time = np.round(np.arange(0.0, SECONDS, 1.0 / rate), 4)
    moved = np.maximum(time - REST, 0.0)
    if kind == "sines":
        slow, fast = random.uniform(1.5, 3.0), random.uniform(4.0, 6.0)
        course = 0.65 * np.sin(slow * moved) + 0.35 * np.sin(fast * moved)
    elif kind == "stairs":
        levels = random.uniform(-1.0, 1.0, 24)
        levels[0] = 0.0
        step = np.floor(moved / 0.7 + 1e-9).astype(int)
        rising = np.clip((moved - 0.7 * step) / 0.02, 0.0, 1.0)
        course = levels[step] + rising * (levels[step + 1] - levels[step])
    else:  # triangles, with rests or without
        turns = np.concatenate([[0.0], random.uniform(0.3, 1.0, 30) * (-1.0) ** np.arange(30)])
        speed, rests = random.uniform(1.2, 2.5), 0.4 if kind == "rests" else 0.0
        corners, stops = [0.0], [0.0]
        for before, after in pairwise(turns):
            corners += [corners[-1] + abs(after - before) / speed]
            corners += [corners[-1] + rests]
            stops += [after, after]
        course = np.interp(moved, corners, stops)
    return time, np.round(course, 4)


MOTIONS = "triangles", "sines", "rests", "stairs"


def record(rig: Rig, random: np.random.Generator, kind: str, folder: Path, name: str) -> Recording:
    """A recording of a rig that is as its model, but for the numbers that are uncertain.

    Args:
        rig: to be recorded.
        random: draws sampling rate, motion, the uncertain numbers, and noise.
        kind: of `MOTIONS`, or "points" for settled points, where the rig is let off once.
        folder: for the model's file.
        name: of the recording.
    """
    model = rig.model
    if model.startswith("<"):
        model = str(folder / f"{name}.xml")
        Path(model).write_text(rig.model, encoding="utf-8")
    time, course = motion(random, "stairs" if kind == "points" else kind)
    if kind == "points":
        time = np.arange(float(POINTS))
        course = random.uniform(0.2, 1.0, POINTS)
        course[POINTS // 2] = -1.0
    bare = Recording(
        name=name,
        model=model,
        source="simulated by experiments/logger_faults",
        settle=rig.settle,
        time=time,
        columns={
            **{c: middle + size * course for c, (_, middle, size) in rig.drive.items()},
            **{c: np.zeros(time.size) for c in rig.measured},
        },
        drive={c: actuator for c, (actuator, _, _) in rig.drive.items()},
        measured={c: Measured(sensor) for c, sensor in rig.measured.items()},
        known=rig.known,
        uncertain=rig.uncertain,
    )
    true = {n: u.value * random.uniform(0.85, 1.15) for n, u in rig.uncertain.items()}
    shown = replay_recording(
        replace(bare, known={**rig.known, **true}, uncertain={}), described=True
    )
    columns, measured = dict(bare.columns), {}
    stated = random.uniform() < STATED
    for column, sensor in rig.measured.items():
        series = shown.columns[column]
        noise = float(random.uniform(*NOISES) * np.ptp(series))
        step = 10.0 ** np.floor(np.log10(ROUNDED * noise))
        columns[column] = np.round((series + random.normal(0.0, noise, time.size)) / step) * step
        measured[column] = Measured(sensor, noise if stated else None)
    return replace(bare, columns=columns, measured=measured)
