"""Rigs that are measured point by point, and readings of them at rest.

The readings come from plain steps of MuJoCo at a constant speed of the drive and whole rests, not
from the schedule by which a diagnosis simulates them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.attach import add_friction
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Adjustable
from tendon_mj.typing import FloatArray
from tests.lab.recorded import recorded
from tests.rigs import STILL, rope

SETTLING = 1.0  # [s]
_SPEED = 0.002  # of the drive [m/s]

# A cable along a duct that turns by 1.8 rad, and then to the end of a lever on a spring.
LEVER = rope(
    "s0 -.12 -.12 0; s1 -.12 -.05 0; s2 -.10 -.02 0; s3 -.07 0 0; s4 -.04 -.01 0",
    "end 0 .03 0",
    name="cable",
    joint='name="lever" axis="0 0 1" stiffness="0.4" damping="0.02"',
    geom='type="capsule" fromto="0 0 0 0 0.06 0" size="0.004" mass="0.03"',
    option=STILL + ' integrator="implicitfast"',
    actuator="",
    sensor='<jointpos name="lever" joint="lever"/>',
)

KNUCKLE = 'axis="0 0 1" damping="0.01"'
# A finger of two joints that one cable closes.
FINGER = rope(
    "s0 -.03 .012 0",
    "a1 .012 .009 0; a2 .04 .009 0",
    "s0 a1 a2 b1 b2",
    name="cable",
    joint=f'<joint name="knuckle" stiffness="0.2" {KNUCKLE}/>',
    geom='type="capsule" fromto="0 0 0 0.05 0 0" size="0.006" mass="0.02"',
    option=STILL + ' integrator="implicitfast"',
    link=f"""<body pos=".05 0 0"><joint name="middle" stiffness="0.15" {KNUCKLE}/>
      <geom type="capsule" fromto="0 0 0 0.035 0 0" size="0.005" mass="0.01"/>
      <site name="b1" pos="0.01 0.008 0"/><site name="b2" pos="0.028 0.008 0"/></body>""",
    actuator="",
    sensor='<jointpos name="knuckle" joint="knuckle"/><jointpos name="middle" joint="middle"/>',
)


def write_rig(mjcf: str, folder: Path, **law: float) -> Path:
    """Write a rig whose cable a reel winds in, through a sheath of that law; returns its path."""
    spec = mujoco.MjSpec.from_string(mjcf)
    add_friction(spec, "cable", name="sheath", reel="reel", **law)
    path = folder / "rig.xml"
    path.write_text(spec.to_xml(), encoding="utf-8")
    return path


def settled(
    rig: Path,
    points: FloatArray,
    measured: Mapping[str, tuple[str, float | None]],
    hidden: Mapping[str, float],
    seed: int,
    **more: object,
) -> Recording:
    """Rests after moves of the reel from point to point [m], of a rig with hidden parameters."""
    adjustable = Adjustable(mujoco.MjModel.from_xml_path(str(rig)))
    adjustable.set(hidden)
    model, data = adjustable.model, adjustable.data
    addresses = [int(model.sensor(name).adr[0]) for name, _ in measured.values()]
    scale, offset = adjustable.commands[model.actuator("reel").id, :2]
    rows, times, last = [], [], 0.0
    step = model.opt.timestep
    for point in points:
        moving = max(1, round(abs(point - last) / _SPEED / step))
        for value in np.linspace(last, point, moving):
            data.ctrl[0] = scale * value + offset
            mujoco.mj_step(model, data)
        mujoco.mj_step(model, data, round(SETTLING / step))
        rows.append(data.sensordata[addresses])
        times.append(data.time)
        last = point
    random = np.random.default_rng(seed)
    read = {}
    for (column, (name, noise)), series in zip(measured.items(), np.array(rows).T, strict=True):
        gain, bias = adjustable.readings[model.sensor(name).id, :2]
        readings = gain * series + bias + random.normal(0.0, noise or 0.0, series.size)
        read[column] = name, noise, readings
    at_rest = {"name": f"points_{seed}", "settling_time": SETTLING}
    return recorded(np.array(times), {"reel_m": ("reel", points)}, read, rig, **at_rest, **more)


def stairs(*, low: float, high: float, steps: int, rows: int) -> FloatArray:
    """(rows,) points up a stair and down again, and so on."""
    up = np.linspace(low, high, steps)
    period = np.concatenate([up, up[-2:0:-1]])
    return np.resize(period, rows)
