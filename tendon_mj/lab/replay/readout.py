"""Model of a sensor and its recorder: clock, gear, delay, lag, scale, drift and offset.

y = scale · x_f(t − delay) + drift · (t − t_0) + offset, with lag · dx_f/dt = x_g − x_f and t_0 the
time of the first sample. Before t_0, x counts as x(t_0).

A reading behind a gear, as a motor's current is, has x_g = x η^{−s}: x/η while the motor winds in
(s = 1) and x η while the load turns it back (s = −1). At rest the gear's friction bears more or
less of the load, s = ``rest_in`` after winding in and s = ``rest_out`` after paying out, each from
−1 to 1. Without a gear x_g = x. If the motor turns it is slower than its column can tell, and
no recording says when s changes: samples there show what was measured, as far as any s explains it.

The delay of MuJoCo's sensors is not used: it is a number of samples fixed when the model is
compiled, and a fit of it would repeat the simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Final, NamedTuple

import mujoco
import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.noise import white_noise
from tendon_mj.lab.units import LARGEST, ROUNDING
from tendon_mj.typing import FloatArray

# of a column that is a control as it stands
PLAIN_COMMAND: Final = {"command_scale": 1.0, "command_offset": 0.0, "command_delay": 0.0}
JOINT_COMMAND: Final = ".command"  # custom text of a model: scale, offset and delay of a joint
USER_NUMBERS = 5  # of a `Readout`, that are user data of MJCF
_FASTEST_STILL = 0.1  # of the largest speed: slower, a drive may count as at rest
_NOISE = 4.0  # standard deviations of a speed that noise makes, likewise
_TURN = 5  # samples that a drive may take to be seen moving


@dataclass(frozen=True)
class Clock:
    """Grid t_0 + k h, k = 0 … steps, and the place of every sample on it."""

    start: float  # t_0, time of the first sample [s]
    timestep: float  # h [s]
    steps: int  # from the first sample to the last
    places: FloatArray  # (n,) of the samples, (t − t_0)/h [-]

    @property
    def time(self) -> FloatArray:
        """(steps+1,) times of the grid [s]."""
        return self.start + self.timestep * np.arange(self.steps + 1, dtype=np.float64)

    def sample(self, series: FloatArray, delay: float = 0.0) -> FloatArray:
        """(steps+1, …) on the grid to (n, …) at the samples: taken there, or linear between.

        ``delay`` ≥ 0 [s] earlier; before the grid it is the first value.
        """
        places = self.places
        if delay > 0.0:
            places = np.maximum(0.0, places - delay / self.timestep)
        below = np.clip(np.floor(places).astype(int), 0, self.steps - 1)
        share = (places - below).reshape(-1, *[1] * (series.ndim - 1))
        between: FloatArray = (1.0 - share) * series[below] + share * series[below + 1]
        return between


def make_clock(time: ArrayLike, longest: float) -> Clock:
    """The grid for samples at ``time`` (n,) [s], in steps no longer than ``longest`` [s].

    The step is the typical (median) interval between samples, divided by the smallest whole number
    that makes it no longer than ``longest``. Regular samples, also with rows left out, therefore
    lie on the grid; others are interpolated.
    """
    stamps = np.asarray(time, float)
    span = stamps[-1] - stamps[0]
    intervals = max(1, round(span / float(np.median(np.diff(stamps)))))
    steps = intervals * max(1, math.ceil(span / intervals / longest * (1.0 - ROUNDING)))
    places = (stamps - stamps[0]) / (span / steps)
    nearest = np.rint(places)
    places = np.where(np.abs(places - nearest) < ROUNDING, nearest, places)
    return Clock(float(stamps[0]), float(span / steps), steps, places)


@dataclass(frozen=True, eq=False)
class Sense:
    """Sense in which a drive moves at its n samples and between them: 2n − 1 in order of time."""

    now: FloatArray  # 1 winding in, −1 paying out, 0 at rest
    last: FloatArray  # of the last motion, 1 or −1

    def at(self, time: FloatArray, grid: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both at times of a grid, from those at and between the samples at ``time`` (n,)."""
        behind = np.clip(np.searchsorted(time, grid + ROUNDING * (grid[1] - grid[0])) - 1, 0, None)
        behind = np.minimum(behind, time.size - 2)
        shares = (grid - time[behind]) / (time[behind + 1] - time[behind])
        places = 2 * behind + np.select([shares < ROUNDING, shares > 1.0 - ROUNDING], [0, 2], 1)
        return self.now[places], self.last[places]

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """(n,) samples next to a motion that is the reverse of the one before or after it."""
        moving = np.flatnonzero(self.now)
        turned = self.now[moving[:-1]] != self.now[moving[1:]]
        samples = np.zeros((self.now.size + 1) // 2, bool)
        for end, begin in zip(moving[:-1][turned], moving[1:][turned], strict=True):
            last, first = end // 2, (begin + 1) // 2
            samples[last : min(last + _TURN, first) + 1] = True
            samples[max(first - _TURN, last) : first + 1] = True
        return samples


def sense_of(time: FloatArray, place: FloatArray, begin: float | None = None) -> Sense:
    """Direction of a drive's motion; ``place`` (n,) grows as it winds in.

    No faster than its noise makes it, it is at rest. At a corner the faster of two motions counts,
    and of equal ones neither. A motion from ``begin`` to the first place is over before the first
    sample; without one the drive holds as after paying out.
    """
    ahead, behind = np.r_[place[1:], place[-1]], np.r_[place[0], place[:-1]]
    elapsed = np.r_[time[1:], time[-1]] - np.r_[time[0], time[:-1]]
    speed, step = (ahead - behind) / elapsed, float(np.median(elapsed))
    fastest = float(np.abs(speed).max())
    noise = _NOISE * math.sqrt(2.0) * white_noise(place, order=5)  # fast motion apart
    still = float(np.clip(noise / step, ROUNDING * fastest, _FASTEST_STILL * fastest))

    def way(speeds: FloatArray) -> FloatArray:
        return np.where(np.abs(speeds) > still, np.sign(speeds), 0.0)

    now = np.empty(2 * place.size - 1)
    now[::2] = way(speed)
    between = way(np.diff(place) / np.diff(time))  # of twice the noise, so only at corners
    now[1::2] = np.where(now[:-1:2] == now[2::2], now[:-1:2], between)
    moved = np.maximum.accumulate(np.where(now != 0.0, np.arange(now.size), -1))
    before = 1.0 if begin is not None and place[0] - begin > noise else -1.0
    return Sense(now, np.where(moved < 0, before, now[moved]))


class Readout(NamedTuple):
    """Numbers of one sensor; the first five in the order of the sensor's ``user`` data in MJCF.

    scale [-], offset [of the reading], delay and lag ≥ 0 [s], drift [of the reading per second],
    efficiency of a gear before it, and rest_in and rest_out −1 … 1 of it [-].
    """

    scale: float = 1.0
    offset: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    drift: float = 0.0
    efficiency: float = 1.0
    rest_in: float = -1.0
    rest_out: float = -1.0

    def of(
        self,
        series: FloatArray,
        clock: Clock,
        time: FloatArray,
        sense: Sense | None = None,
        measured: FloatArray | None = None,
    ) -> FloatArray:
        """(steps+1,) simulated on the clock's grid to (n,) as recorded at the sample times [s].

        ``sense`` is that of the drive behind the gear; without it no gear is. ``measured`` (n,)
        decides what is shown where the drive turns.
        """
        if self.efficiency == 1.0 or sense is None:
            return self._read(series, clock, time)

        def geared(state: FloatArray | float) -> FloatArray:
            loss = self.efficiency ** (-state * np.sign(series))
            return self._read(series * loss, clock, time)

        now, last = sense.at(time, clock.time)
        resting = np.where(last > 0.0, self.rest_in, self.rest_out)
        read = geared(np.where(now != 0.0, now, resting))
        if measured is not None and sense.turns.any():
            ends = geared(-1.0), geared(1.0)
            between = np.clip(measured, np.minimum(*ends), np.maximum(*ends))
            read = np.where(sense.turns, between, read)
        return read

    def _read(self, series: FloatArray, clock: Clock, time: FloatArray) -> FloatArray:
        """The reading of what a sensor meets, behind its gear."""
        if self.lag > 0.0:
            series = low_pass(series, clock.timestep, self.lag)
        samples = clock.sample(series, self.delay)
        read: FloatArray = self.scale * samples + self.drift * (time - time[0]) + self.offset
        return read


def low_pass(series: FloatArray, timestep: float, lag: float) -> FloatArray:
    """First-order lag [s] of a series (n,) that is linear between steps, at rest before the first.

    Exact at the steps: x_f⁺ = a x_f + b_1 x + b_0 x⁺ with a = e^{−r}, r = timestep/lag.
    """
    ratio = timestep / lag
    passed = -math.expm1(-ratio)
    now = 1.0 - passed / ratio
    before = passed - now
    start = [(1.0 - now) * series[0]]
    smooth, _ = scipy.signal.lfilter([now, before], [1.0, -(1.0 - passed)], series, zi=start)
    return np.asarray(smooth, np.float64)


def stored_readouts(model: mujoco.MjModel) -> FloatArray:
    """(nsensor, 5) from the sensors' user data; a row of zeros, or none, is a plain sensor's."""
    return _stored(model.sensor_user, Readout()[:USER_NUMBERS], USER_NUMBERS)


def plain_commands(model: mujoco.MjModel) -> dict[str, float]:
    """Parameter → value with which a column is a control, of actuators that say otherwise."""
    return {
        f"{model.actuator(k).name}.{parameter}": value
        for k, stored in enumerate(stored_commands(model).tolist())
        if model.actuator(k).name and stored != list(PLAIN_COMMAND.values())
        for parameter, value in PLAIN_COMMAND.items()
    }


def stored_commands(model: mujoco.MjModel) -> FloatArray:
    """(nactuator, 3) scale, offset and delay from the actuators' user data, likewise.

    With two numbers, scale and offset, no command is late.
    """
    return _stored(model.actuator_user, (1.0, 0.0, 0.0), 2)


def _stored(user: FloatArray, plain: tuple[float, ...], fewest: int) -> FloatArray:
    """Rows of user data; one of zeros, or of fewer numbers than ``fewest``, is ``plain``."""
    rows, size = np.tile(plain, (len(user), 1)), min(user.shape[1], len(plain))
    if size >= fewest:
        given = user[:, :size]
        rows[:, :size] = np.where(given.any(axis=1, keepdims=True), given, rows[:, :size])
    return rows


def stored_joint_commands(model: mujoco.MjModel) -> FloatArray:
    """(njnt, 3) scale, offset and delay of columns that prescribe joints, from custom texts.

    The user data of joints are left to the model's author.
    """
    rows = np.tile([1.0, 0.0, 0.0], (model.njnt, 1))
    joint = partial(mujoco.mj_name2id, model, mujoco.mjtObj.mjOBJ_JOINT.value)
    stored = custom_numbers(model, JOINT_COMMAND, 3, lambda name: joint(name) >= 0)
    for name, command in stored.items():
        rows[joint(name)] = command
    return rows


def custom_numbers(
    model: mujoco.MjModel, ending: str, count: int, ours: Callable[[str], bool]
) -> dict[str, list[float]]:
    """Name → the ``count`` numbers of the custom text ``<name><ending>``, where it is ours."""
    texts = {
        str(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, k)): k for k in range(model.ntext)
    }
    return {
        name.removesuffix(ending): _numbers(model, k, count)
        for name, k in texts.items()
        if name.endswith(ending) and ours(name.removesuffix(ending))
    }


def _numbers(model: mujoco.MjModel, text: int, count: int) -> list[float]:
    start, size = model.text_adr[text], model.text_size[text]
    content = bytes(model.text_data[start : start + size]).rstrip(b"\0").decode(errors="replace")
    try:
        numbers = [float(word) for word in content.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(number) <= LARGEST for number in numbers):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, text)
        raise InvalidValueError(
            f"custom text {name!r} of the model is {content[:60]!r}; a name that ends so holds"
            f" {count} finite number{'s' if count > 1 else ''}; mend it, or take it out"
        )
    return numbers
