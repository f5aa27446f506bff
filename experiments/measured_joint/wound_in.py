"""Simulator of the rig that starts as its recordings do: wound in until the load cells read 5 N.

Before a recording both tendons were wound in until each load cell read what the first sample says.
Friction then holds back what it can: the tension falls along the sheath, the more the further it is
bent, and how much tendon that takes depends on every number of the model. It is found by simulating
the first two samples: the tension grows linearly with the tendon wound in, once all of it slides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from experiments.measured_joint.recording import REELS, TENSIONS
from tendon_mj import Simulator
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_WOUND = 2e-3, 4e-3  # first two trials [m]
_TRIALS = 2  # secant steps after these
_LONGEST = 0.1  # tendon wound in [m]
_FLAT = 1.0  # least growth of a tension that counts [N/m]


class WoundIn(Simulator):
    """`Simulator` whose tendons are wound in before the first sample.

    Args:
        recordings: with the columns `REELS` drive.
        threads: simulations at a time; default: as many as there are cores.
    """

    def __init__(self, recordings: Sequence[Recording], threads: int | None = None) -> None:
        super().__init__(recordings, threads=threads)
        starts = [
            replace(r, time=r.time[:2], columns={c: v[:2] for c, v in r.columns.items()})
            for r in recordings
        ]
        self._starts = Simulator(starts, threads=threads)

    def __call__(
        self, parameter_sets: Sequence[Mapping[str, float]]
    ) -> list[list[dict[str, FloatArray]]]:
        """Simulate every recording with every set of parameters, each wound in for itself."""
        wound = self._wind_in(parameter_sets)
        return super().__call__(
            [
                {**values, **self._offsets(lengths)}
                for values, lengths in zip(parameter_sets, wound, strict=True)
            ]
        )

    def _offsets(self, lengths: FloatArray) -> dict[str, float]:
        """Parameters that wind in (recordings, 2) lengths [m]."""
        return {
            f"{reel}.command_offset @ {recording.name}": float(length)
            for recording, row in zip(self.recordings, lengths, strict=True)
            for reel, length in zip(REELS, row, strict=True)
        }

    def _wind_in(self, parameter_sets: Sequence[Mapping[str, float]]) -> FloatArray:
        """(sets, recordings, 2) lengths [m] with which the load cells read the first sample."""
        aim = np.array([[r.columns[c][0] for c in TENSIONS] for r in self.recordings])
        shape = (len(parameter_sets), *aim.shape)
        before, now = (np.full(shape, length) for length in _WOUND)
        read = self._read(parameter_sets, before)
        for _ in range(_TRIALS):
            after = self._read(parameter_sets, now)
            with np.errstate(invalid="ignore", divide="ignore"):
                slope = (after - read) / (now - before)
                step = np.where(slope > _FLAT, (aim - after) / slope, 0.0)
            before, read = now, after
            now = np.clip(now + step, 0.0, _LONGEST)
        return now

    def _read(
        self, parameter_sets: Sequence[Mapping[str, float]], lengths: FloatArray
    ) -> FloatArray:
        """(sets, recordings, 2) readings of the load cells at the first sample [N]."""
        answers = self._starts(
            [
                {**values, **self._offsets(row)}
                for values, row in zip(parameter_sets, lengths, strict=True)
            ]
        )
        return np.array([[[series[c][0] for c in TENSIONS] for series in row] for row in answers])
