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
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Adjustable
from tendon_mj.typing import FloatArray

SETTLING = 2.0  # [s]
_SPEED = 0.002  # of the drive [m/s]

# A cable along a duct that turns by 1.8 rad, and then to the end of a lever on a spring.
LEVER = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody>
    <site name="s0" pos="-0.12 -0.12 0"/>
    <site name="s1" pos="-0.12 -0.05 0"/>
    <site name="s2" pos="-0.10 -0.02 0"/>
    <site name="s3" pos="-0.07 0 0"/>
    <site name="s4" pos="-0.04 -0.01 0"/>
    <body>
      <joint name="lever" axis="0 0 1" stiffness="0.4" damping="0.02"/>
      <geom type="capsule" fromto="0 0 0 0 0.06 0" size="0.004" mass="0.03"/>
      <site name="end" pos="0 0.03 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="cable">
      <site site="s0"/><site site="s1"/><site site="s2"/><site site="s3"/><site site="s4"/>
      <site site="end"/>
    </spatial>
  </tendon>
  <sensor><jointpos name="lever" joint="lever"/></sensor>
</mujoco>
"""

# A finger of two joints that one cable closes.
FINGER = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/>
  <default><joint axis="0 0 1" damping="0.01"/></default>
  <worldbody>
    <site name="s0" pos="-0.03 0.012 0"/>
    <body>
      <joint name="knuckle" stiffness="0.2"/>
      <geom type="capsule" fromto="0 0 0 0.05 0 0" size="0.006" mass="0.02"/>
      <site name="a1" pos="0.012 0.009 0"/>
      <site name="a2" pos="0.04 0.009 0"/>
      <body pos="0.05 0 0">
        <joint name="middle" stiffness="0.15"/>
        <geom type="capsule" fromto="0 0 0 0.035 0 0" size="0.005" mass="0.01"/>
        <site name="b1" pos="0.01 0.008 0"/>
        <site name="b2" pos="0.028 0.008 0"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="cable">
      <site site="s0"/><site site="a1"/><site site="a2"/><site site="b1"/><site site="b2"/>
    </spatial>
  </tendon>
  <sensor>
    <jointpos name="knuckle" joint="knuckle"/>
    <jointpos name="middle" joint="middle"/>
  </sensor>
</mujoco>
"""


def write_rig(mjcf: str, folder: Path, **law: float) -> Path:
    """Write a rig whose cable a reel winds in, through a sheath of that law; returns its path."""
    spec = mujoco.MjSpec.from_string(mjcf)
    add_friction(spec, "cable", reel="reel", **law)
    path = folder / "rig.xml"
    path.write_text(spec.to_xml(), encoding="utf-8")
    return path


def settled(
    rig: Path,
    points: FloatArray,
    measured: Mapping[str, Measured],
    hidden: Mapping[str, float],
    seed: int,
    **more: object,
) -> Recording:
    """Rests after moves of the reel from point to point [m], of a rig with hidden parameters."""
    adjustable = Adjustable(mujoco.MjModel.from_xml_path(str(rig)))
    adjustable.set(hidden)
    model, data = adjustable.model, adjustable.data
    addresses = {c: int(model.sensor(m.sensor).adr[0]) for c, m in measured.items()}
    scale, offset = adjustable.commands[model.actuator("reel").id, :2]
    rows, times, last = [], [], 0.0
    step = model.opt.timestep
    for point in points:
        moving = max(1, round(abs(point - last) / _SPEED / step))
        drive = np.append(np.linspace(last, point, moving), np.full(round(SETTLING / step), point))
        for value in drive:
            data.ctrl[0] = scale * value + offset
            mujoco.mj_step(model, data)
        rows.append([data.sensordata[address] for address in addresses.values()])
        times.append(data.time)
        last = point
    random = np.random.default_rng(seed)
    columns = {"reel_m": points}
    for column, series in zip(measured, np.array(rows).T, strict=True):
        sensor = model.sensor(measured[column].sensor).id
        gain, bias = adjustable.readings[sensor, :2]
        noise = measured[column].noise or 0.0
        columns[column] = gain * series + bias + random.normal(0.0, noise, series.size)
    return Recording(
        name=f"points_{seed}",
        model=str(rig),
        source="made up, at rest",
        time=np.array(times),
        columns=columns,
        drive={"reel_m": "reel"},
        measured=measured,
        settling_time=SETTLING,
        **more,  # type: ignore[arg-type]
    )


def stairs(*, low: float, high: float, steps: int, rows: int) -> FloatArray:
    """(rows,) points up a stair and down again, and so on."""
    up = np.linspace(low, high, steps)
    period = np.concatenate([up, up[-2:0:-1]])
    return np.resize(period, rows)
