"""Trial of a reference: residuals in units of noise, before and after calibration."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np

from experiments.hidden_effects.suite.rig_state import R
from experiments.hidden_effects.suite.strength_search import calibration_projector
from tendon_mj.typing import FloatArray

PERTURBATION = 1.01  # factor on a parameter, to find the sensitivity of the readings to it


def simulate_each(
    references: Sequence[R], drives: Sequence[FloatArray], fine: bool = True
) -> list[FloatArray]:
    """Readings (sensors, samples) of each reference under its own drive, without noise."""
    pairs = zip(references, drives, strict=True)
    return [reference.simulate([drive], fine)[0] for reference, drive in pairs]


def rms(residual: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(residual**2)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial(Generic[R]):
    """Training recordings of a rig without what is hidden.

    Attributes:
        references: the rig in the bend of each recording.
        drives: of each [the drive's unit].
        readings: (sensors, samples) of each, in long steps and without noise.
        noise: (sensors,) standard deviations in the sensors' units.
        uncertain: attributes that are calibrated for all recordings together.
        session: whether pretension and zeros are calibrated for each recording by itself.
    """

    references: Sequence[R]
    drives: Sequence[FloatArray]
    readings: Sequence[FloatArray]
    noise: FloatArray
    uncertain: tuple[str, ...]
    session: bool = False

    def residuals(self, change: Callable[[R], R]) -> FloatArray:
        """(m,) by which a change of the references changes their readings [noise]."""
        return self.of(simulate_each([change(r) for r in self.references], self.drives, fine=False))

    def of(self, readings: Sequence[FloatArray]) -> FloatArray:
        """(m,) residuals of readings, by recording, sensor and sample [noise]."""
        return np.concatenate(
            [
                ((a - b) / self.noise[:, None]).ravel()
                for a, b in zip(readings, self.readings, strict=True)
            ]
        )

    def sensitivity(self, attribute: str) -> FloatArray:
        """(m,) by which readings change when an attribute grows by a hundredth [noise]."""
        return self.residuals(
            lambda reference: dataclasses.replace(
                reference, **{attribute: PERTURBATION * getattr(reference, attribute)}
            )
        )

    @cached_property
    def of_recordings(self) -> list[FloatArray]:
        """For each recording (m,), 1 on its residuals and 0 elsewhere."""
        sizes = [reading.size for reading in self.readings]
        owner = np.repeat(np.arange(len(sizes)), sizes)
        return [(owner == k).astype(float) for k in range(len(sizes))]

    @cached_property
    def pretension_sensitivity(self) -> FloatArray:
        """`sensitivity` to the pretension."""
        return self.sensitivity("pretension")

    @cached_property
    def uncalibrated(self) -> Callable[[FloatArray], FloatArray]:
        """Projector onto the residuals that calibration cannot remove."""
        columns = [self.sensitivity(name) for name in self.uncertain]
        if self.session:
            columns += [own * self.pretension_sensitivity for own in self.of_recordings]
            columns += self._zeros()
        return calibration_projector(columns)

    def _zeros(self) -> list[FloatArray]:
        """Sensitivity to the zero of each sensor in each recording."""
        columns = []
        for k, reading in enumerate(self.readings):
            for sensor in range(len(reading)):
                shifted = [r.copy() for r in self.readings]
                shifted[k][sensor] += self.noise[sensor]
                columns.append(self.of(shifted))
        return columns

    def ratio(self, change: Callable[[R], R]) -> float:
        """Rms of what a change of the references leaves after calibration [noise]."""
        return rms(self.uncalibrated(self.residuals(change)))
