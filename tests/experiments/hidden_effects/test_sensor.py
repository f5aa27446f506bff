"""Laws of the references' sensors."""

import numpy as np
import pytest

from experiments.hidden_effects.excitation import Sensor


def test_lag_and_delay_shift_a_ramp_by_their_time():
    time = np.linspace(0.0, 1.0, 1001)
    for sensor in (Sensor(lag=0.02), Sensor(delay=0.02)):
        late = sensor.read(time, 5.0 * time, time)[500:]
        assert late == pytest.approx(5.0 * (time[500:] - 0.02), abs=1e-6)
