"""Model of a sensor and its recorder: delay, lag, scale, drift and offset of a quantity.

y = scale · x_f(t − delay) + drift · (t − t_0) + offset, with lag · dx_f/dt = x − x_f and t_0 the
time of the first sample. Before it, x counts as what it was then.

MuJoCo's sensors have a delay of their own. It is not used here: it is a number of samples fixed
when the model is compiled, so a replay's step and a fit's delay could not be chosen, it knows no
lag before it, and a simulation would be run anew for what is a matter of reading it off.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tendon_mj.replay.clock import Clock
from tendon_mj.replay.live_parameters import custom_numbers

FloatArray = NDArray[np.float64]

JOINT_COMMAND: Final = ".command"  # custom text of a model: scale, offset and delay of a joint


class Readout(NamedTuple):
    """Numbers of one sensor, in the order in which MJCF holds them as the sensor's ``user`` data.

    scale [-], offset [of the reading], delay and lag ≥ 0 [s], drift [of the reading per second].
    """

    scale: float = 1.0
    offset: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    drift: float = 0.0

    def of(self, series: FloatArray, clock: Clock, time: FloatArray) -> FloatArray:
        """(steps+1,) simulated on the clock's grid to (n,) as recorded at the sample times [s]."""
        if self.lag > 0.0:
            series = low_pass(series, clock.timestep, self.lag)
        samples = clock.sample(series, self.delay)
        read: FloatArray = self.scale * samples + self.drift * (time - time[0]) + self.offset
        return read


def low_pass(series: FloatArray, timestep: float, lag: float) -> FloatArray:
    """First-order lag of a series that is linear between steps, at rest before the first.

    Exact at the steps: x_f⁺ = a x_f + b_1 x + b_0 x⁺ with a = e^{−r}, r = h/lag.

    Args:
        series: (n,) in steps of ``timestep`` [s].
        lag: time constant > 0 [s].
    """
    ratio = timestep / lag
    passed = -math.expm1(-ratio)
    now = 1.0 - passed / ratio
    before = passed - now
    start = [(1.0 - now) * series[0]]
    smooth, _ = lfilter([now, before], [1.0, -(1.0 - passed)], series, zi=start)
    return np.asarray(smooth, np.float64)


def stored_readouts(model: mujoco.MjModel) -> FloatArray:
    """(nsensor, 5) from the sensors' user data; a row of zeros, or none, is a plain sensor's."""
    size = len(Readout._fields)
    rows = np.tile(np.array(Readout()), (model.nsensor, 1))
    if model.nuser_sensor >= size:
        given = model.sensor_user[:, :size]
        rows = np.where(given.any(axis=1)[:, None], given, rows)
    return rows


def plain_commands(model: mujoco.MjModel) -> dict[str, float]:
    """Parameter → value with which a column is a control, of actuators that say otherwise."""
    plain = {"command_scale": 1.0, "command_offset": 0.0, "command_delay": 0.0}
    return {
        f"{model.actuator(k).name}.{parameter}": value
        for k, stored in enumerate(stored_commands(model).tolist())
        if model.actuator(k).name and stored != list(plain.values())
        for parameter, value in plain.items()
    }


def stored_commands(model: mujoco.MjModel) -> FloatArray:
    """(nactuator, 3) scale, offset and delay from the actuators' user data, likewise.

    With two numbers, scale and offset, no command is late.
    """
    rows = np.tile([1.0, 0.0, 0.0], (model.nactuator, 1))
    size = min(model.nuser_actuator, 3)
    if size >= 2:
        given = model.actuator_user[:, :size]
        rows[:, :size] = np.where(given.any(axis=1)[:, None], given, rows[:, :size])
    return rows


def stored_joint_commands(model: mujoco.MjModel) -> FloatArray:
    """(njnt, 3) scale, offset and delay of columns that prescribe joints, from custom texts.

    The user data of joints are left to the model's author.
    """
    rows = np.tile([1.0, 0.0, 0.0], (model.njnt, 1))
    for k in range(model.ntext):
        name = str(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, k))
        joint = mujoco.mj_name2id(
            model, mujoco.mjtObj.mjOBJ_JOINT, name.removesuffix(JOINT_COMMAND)
        )
        if name.endswith(JOINT_COMMAND) and joint >= 0:
            rows[joint] = custom_numbers(model, k, 3)
    return rows
