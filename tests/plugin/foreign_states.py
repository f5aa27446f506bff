"""Models of every kind of sheath, stepped from states that hold anything.

``python -m tests.plugin.foreign_states`` steps them from 300 such states; a crash ends it.
"""

import os
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj import add_friction
from tests.plugin.models import arm, fixed_sheaths
from tests.plugin.servos import hand

DRIVEN = """
<mujoco>
  <option integrator="implicitfast"/>
  <worldbody>
    <site name="a" pos="-.1 0 .03"/><geom name="drum" type="cylinder" size=".02 .1" zaxis="0 1 0"/>
    <site name="side" pos="0 0 .05"/><site name="k" pos="-.02 0 .06"/>
    <body>
      <joint name="elbow" axis="0 1 0" range="-60 60" damping=".01" armature=".01"/>
      <geom type="capsule" size=".01" fromto="0 0 0 .2 0 0" contype="0" conaffinity="0"/>
      <site name="b" pos=".1 0 .02"/><site name="c" pos=".2 0 .03"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="wrapped"><site site="a"/><geom geom="drum" sidesite="side"/><site site="b"/>
      <site site="c"/></spatial>
    <spatial name="sprung" stiffness="50" springlength=".1 .2"><site site="a"/><site site="k"/>
      <site site="c"/></spatial>
    <spatial name="branched" stiffness="60"><site site="a"/><site site="b"/><pulley divisor="2"/>
      <site site="a"/><site site="b"/><site site="c"/></spatial>
  </tendon>
  <actuator><motor name="pull" tendon="wrapped"/></actuator>
</mujoco>
"""
CASES = 300


def driven():
    spec = mujoco.MjSpec.from_string(DRIVEN)
    return add_friction(spec, "*", friction=0.2, arc_guides=2).compile()


def reeled():
    return fixed_sheaths([{"guides": 6, "bend": 2.0, "friction": 0.2, "pretension": 20.0}] * 2)


MODELS = {
    "wound": lambda: arm(spools=True),
    "reeled": reeled,
    "driven": driven,
    "servo": lambda: hand(period=0.002, delay=0.003).compile(),
}


def given():
    """Models of others, with friction on all their tendons that actuators pull."""
    for path in sorted(Path(os.environ.get("TENDON_MJ_MODELS", "/nowhere")).glob("*.xml")):
        yield add_friction(mujoco.MjSpec.from_file(str(path)), "*", friction=0.1).compile()


def anything(random, count, kept):
    """Numbers of all kinds, in part those of a true state."""
    kind = random.integers(7)
    if kind == 0:
        return random.integers(0, 2**63, count, dtype=np.uint64).view(np.float64)
    if kind == 1:
        return random.normal(size=count) * 10.0 ** random.integers(-3, 12)
    if kind == 2:
        return random.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0, -1.0], count)
    if kind == 3:
        return random.integers(-3, 50, count).astype(float)
    numbers = kept.copy()
    if kind == 4:
        return np.roll(numbers, random.integers(count))
    where = random.random(count) < 10.0 ** -random.integers(1, 4)
    numbers[where] = random.choice([np.nan, np.inf, -1e300, 3.0, 1e6], where.sum())
    return numbers


def moved(model):
    data = mujoco.MjData(model)
    data.ctrl[:] = 1e-3
    mujoco.mj_step(model, data, 5)
    return data.plugin_state.copy()


def try_all(model, cases):
    random, kept = np.random.default_rng(1), moved(model)
    starts = (mujoco.mj_step, mujoco.mj_forward, mujoco.mj_sensorVel, mujoco.mj_fwdActuation)
    for case in range(cases):
        data = mujoco.MjData(model)
        data.plugin_state[:] = anything(random, kept.size, kept)
        if case % 5 == 4 and hasattr(mujoco, "mj_Euler"):
            mujoco.mj_Euler(model, data)  # advances what was not evaluated
        else:
            starts[case % 5 % 4](model, data)
        mujoco.mj_step(model, data, 2)


if __name__ == "__main__":
    for make in MODELS.values():
        try_all(make(), CASES // len(MODELS))
    for model in given():
        try_all(model, 20)
