"""Effects of a transmission on the bench without MuJoCo, and which it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.sheath_bench import drive_sheath
from tendon_mj.errors import InvalidValueError
from tendon_mj.sheath import Law
from tests.refusals import refusing

LAW = Law(axial_stiffness=20e3, friction=0.2, pretension=30.0)
RIG = {"length": 0.5, "bend": 2.0, "output_stiffness": 5e3}
WAY = 0.015 * np.sin(np.linspace(0.0, 2.5 * np.pi, 600))


def test_a_drive_with_backlash_draws_what_play_leaves():
    drum = drive_sheath(WAY, replace(LAW, backlash=2e-3), **RIG)
    rigid = drive_sheath(WAY, LAW, **RIG)
    np.testing.assert_array_equal(drum.input_displacement, WAY)
    top = np.argmax(WAY)
    # a millimetre later on the way up, and it stays on top for two
    for at in (0.004, 0.010):
        tensions = [np.interp(at + d, WAY[: top + 1], x.input_tension[: top + 1])
                    for d, x in ((1e-3, drum), (0.0, rigid))]  # fmt: skip
        assert tensions[0] == pytest.approx(tensions[1], rel=1e-3)
    waits = (np.arange(len(WAY)) > top) & (np.maximum.accumulate(WAY) - WAY < 2e-3)
    waits &= np.arange(len(WAY)) < top + 60
    np.testing.assert_allclose(drum.input_tension[waits], drum.input_tension[top], rtol=1e-9)


@pytest.mark.parametrize(
    "effect",
    [
        {"stribeck_friction": 0.1, "stribeck_velocity": 0.1},
        {"viscous_friction": 0.1},
        {"friction_gradient": 0.1},
        {"friction_drift": 0.1},
        {"stiffening": 0.1},
        {"creep": 0.1, "creep_time": 1.0},
        {"tendon_mass": 0.1},
    ],
)
def test_what_needs_time_is_refused(effect):
    with refusing(InvalidValueError, f"{next(iter(effect))} = 0.1", "bench"):
        drive_sheath(WAY, replace(LAW, **effect), **RIG)


def test_a_tension_knows_no_backlash():
    with refusing(InvalidValueError, "backlash = 0.001 [m]"):
        drive_sheath([40.0], replace(LAW, backlash=1e-3), **RIG, by_tension=True)
