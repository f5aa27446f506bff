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


def losses(**effects):
    """ln T_in/T_out at the end of a pull and late on the way back."""
    way = np.concatenate([np.linspace(0.0, 0.015, 50), np.linspace(0.015, 0.01, 50)])
    seen = drive_sheath(way, replace(LAW, **effects), **RIG)
    loss = np.log(seen.input_tension / seen.output_tension)
    assert seen.unsolved == 0
    return loss[49], loss[-1]


def test_extra_bend_rubs_like_bend():
    np.testing.assert_allclose(losses(extra_bend=0.5), [0.5, -0.5], rtol=1e-9)
    np.testing.assert_allclose(losses(extra_bend=-9.0), 0.0, atol=1e-12)


def test_friction_differs_by_direction():
    np.testing.assert_allclose(losses(direction_asymmetry=0.25), [0.5, -0.3], rtol=1e-9)


def test_the_mount_is_a_spring_at_the_input():
    law = replace(LAW, friction=0.0)
    plain = drive_sheath([40.0, 60.0], law, **RIG, by_tension=True).input_displacement
    soft = drive_sheath([40.0, 60.0], replace(law, sheath_compliance=1e-4), **RIG, by_tension=True)
    # what is wound in is unstretched, a strain shorter than what the mount gives up
    np.testing.assert_allclose(soft.input_displacement - plain, [1e-3, 3e-3], rtol=4e-3)


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
