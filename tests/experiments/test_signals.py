"""The rig with a motor rests where its servo bears the pretension."""

import numpy as np
import pytest

from experiments.signals import NOISE, SETS, plan, write_rig
from tendon_mj import replay_recording


def test_the_rig_is_at_rest_at_a_command_of_0(tmp_path):
    columns = tuple({column: None for names in SETS.values() for column in names})
    rest = plan(write_rig(tmp_path / "rig.xml"), "rest", np.zeros(25), columns)
    read = replay_recording(rest).columns
    assert read["output_N"] == pytest.approx(15.0, abs=NOISE["output_N"])
    assert read["motor_Nm"] == pytest.approx(0.15, abs=NOISE["motor_Nm"])
    assert np.abs(read["lever_rad"]).max() < NOISE["lever_rad"]
