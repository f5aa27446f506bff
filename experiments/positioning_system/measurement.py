"""The measured file: reference, position and motor force of a carriage on a ball screw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import find_peaks

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import read_table
from tendon_mj.typing import FloatArray

COLUMNS = ("time_s", "reference_m", "position_m", "motor_force_N")
_PROMINENCE = 0.5  # of the travel: a turning point and no ripple


@dataclass(frozen=True)
class Measurement:
    """Samples at even times.

    Attributes:
        time: [s].
        reference, position: commanded and measured place of the carriage [m].
        force: of the motor [N].
    """

    time: FloatArray
    reference: FloatArray
    position: FloatArray
    force: FloatArray

    def reproducibility(self) -> tuple[float, float]:
        """Standard deviations of position [m] and force [N] from cycle to cycle.

        Raises:
            RecordingError: the reference does not repeat.
        """
        needed = _PROMINENCE * float(np.ptp(self.reference))
        turns = find_peaks(self.reference, prominence=needed)[0]
        if turns.size < 2:
            raise RecordingError("the reference turns back at its far end less than twice")
        period = int(np.median(np.diff(turns)))
        position, force = (
            float(np.std(series[period:] - series[:-period]) / np.sqrt(2.0))
            for series in (self.position, self.force)
        )
        return position, force

    def servo_gains(self) -> tuple[float, float, float]:
        """k_p [N/m] and k_v [N s/m] of force = k_p (reference − position) − k_v rate, and the rms.

        The rate is the difference to the sample before, as a servo that samples forms it. The fit
        has a constant beside the two, which is not returned; the rms is what it leaves [N].
        """
        rate = np.diff(self.position) / np.diff(self.time)
        lead = (self.reference - self.position)[1:]
        columns = np.column_stack([lead, -rate, np.ones(rate.size)])
        fitted = np.linalg.lstsq(columns, self.force[1:], rcond=None)[0]
        left = columns @ fitted - self.force[1:]
        return float(fitted[0]), float(fitted[1]), float(np.sqrt(np.mean(left**2)))


def read_measurement(path: Path) -> Measurement:
    """Read the file.

    Raises:
        RecordingError: a header that is not this file's, or an invalid table.
    """
    table = read_table(path)
    if tuple(table) != COLUMNS:
        raise RecordingError(f"{path}, row 1: columns are {tuple(table)}, not {COLUMNS}")
    return Measurement(*table.values())
