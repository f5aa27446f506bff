"""Experiments within bounds, as templates of recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.diagnosis import MakeSimulator
from tendon_mj.lab.experiment_design.bounds import ExperimentBounds
from tendon_mj.lab.experiment_design.motion import NUMBERS, Motion, motion_at, rounded
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, column_unit
from tendon_mj.typing import FloatArray

_SOURCE = "suggested by tendon-mj and not recorded yet: measured columns are to be filled in"


@dataclass(frozen=True, eq=False)
class Experiment:
    """An experiment that has not been run.

    Attributes:
        motions: driven column → how it moves.
        states: parameter → value that is set for it [SI].
        besides: columns that are to be measured, and were not before.
        recording: template, whose measured columns are 0.
    """

    motions: Mapping[str, Motion]
    states: Mapping[str, float]
    besides: Sequence[str]
    recording: Recording

    @property
    def words(self) -> str:
        """What to record."""
        duration = float(self.recording.time[-1])
        moved = " and ".join(
            f"{column.removesuffix('_' + column_unit(column))}"
            f" {motion.words(column_unit(column), duration)}"
            for column, motion in self.motions.items()
        )
        held = ", ".join(f"{name} = {value:g}" for name, value in self.states.items())
        read = " and ".join(c.removesuffix("_" + column_unit(c)) for c in self.besides)
        return (
            f"{duration:.3g} s of {moved}{f', with {held}' if held else ''}"
            f"{f', and measure {read} too' if read else ''}"
        )


@dataclass(frozen=True, eq=False)
class Family:
    """All experiments within bounds, as points of a unit cube.

    Attributes:
        recordings: that there are; the first one says what an experiment does not change.
        bounds: of the rig.
        besides: whether the sensors are read that the rig could read besides.
    """

    recordings: Sequence[Recording]
    bounds: ExperimentBounds
    besides: bool = False

    @property
    def dimensions(self) -> int:
        """Of the cube: five for each driven column, and one for each state."""
        return NUMBERS * len(self.bounds.drive) + len(self.bounds.states)

    @property
    def shapes(self) -> list[int]:
        """Dimensions that choose the shape of a motion."""
        return [NUMBERS * k for k in range(len(self.bounds.drive))]

    def at(self, point: FloatArray, name: str) -> Experiment:
        """The experiment at a point (dimensions,) of the cube."""
        first = self.recordings[0]
        interval = float(np.median(np.diff(first.time)))
        longest = max(float(r.time[-1] - r.time[0]) for r in self.recordings)
        duration = self.bounds.duration or longest
        time = np.round(np.arange(round(duration / interval) + 1) * interval, 9)
        begins = {column: float(first.columns[column][0]) for column in first.drive}
        motions, columns = {}, {}
        for k, (column, bounds) in enumerate(self.bounds.drive.items()):
            part = point[NUMBERS * k : NUMBERS * (k + 1)]
            start = float(np.clip(begins[column], bounds.low, bounds.high))
            motions[column] = motion_at(part, bounds, start, duration, interval)
        for column, start in begins.items():
            motion = motions.get(column)
            still = np.full(time.size, start)
            columns[column] = still if motion is None else motion.series(time)
        besides = self.bounds.measure if self.besides else {}
        measured = {**first.measured, **besides}
        columns |= {column: np.zeros(time.size) for column in measured}
        shares = point[NUMBERS * len(motions) :]
        states = {
            name: float(np.clip(rounded(low + share * (high - low), high - low), low, high))
            for share, (name, (low, high)) in zip(shares, self.bounds.states.items(), strict=True)
        }
        anew = {
            n: replace(first.session[n], value=v) for n, v in states.items() if n in first.session
        }
        known = {n: v for n, v in states.items() if n not in anew}
        recording = Recording(
            name=name,
            model=first.model,
            source=_SOURCE,
            time=time,
            columns=columns,
            drive=first.drive,
            measured=measured,
            known={**first.known, **known},
            uncertain=first.uncertain,
            session={**first.session, **anew},
            hold=first.hold,
            settle=first.settle,
            settling_time=first.settling_time,
        )
        return Experiment(motions, states, tuple(besides), recording)


def draw_experiment(
    recordings: Sequence[Recording], bounds: ExperimentBounds, seed: int, name: str = "drawn"
) -> Experiment:
    """Draw an experiment within bounds at random, with which a suggested one can be compared."""
    family = Family(tuple(recordings), bounds)
    return family.at(np.random.default_rng(seed).random(family.dimensions), name)


def check_bounds(
    recordings: Sequence[Recording],
    bounds: ExperimentBounds,
    simulator: MakeSimulator = Simulator,
) -> None:
    """Refuse bounds within which no experiment can be simulated.

    Raises:
        UnknownNameError: the bounds name what the rig does not have.
        InvalidValueError: an experiment within them is no recording of the model.
    """
    bounds.check(recordings[0], simulator(recordings).parameters)
    family = Family(recordings, bounds, besides=bool(bounds.measure))
    try:
        for share in (0.0, 0.5, 1.0):
            simulator([family.at(np.full(family.dimensions, share), "checked").recording])
    except TendonError as error:
        raise InvalidValueError(f"bounds: {error}") from None
