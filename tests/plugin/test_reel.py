"""A reel winds in what its actuator has MuJoCo do: control, range, gear, group and flags."""

import mujoco
import numpy as np
import pytest

from tendon_mj.models import Bench, build_bench

FLAG = mujoco.mjtDisableBit
CONTROL = 3e-4  # [m]


def readings(control=CONTROL, *, flags=0, group=0, disabled=0, **attributes):
    """Tensions of both ends [N] and tendon wound in [m] after a ramp of the control."""
    spec = build_bench(Bench())
    reel = spec.actuator("reel")
    reel.group = group
    for name, value in attributes.items():
        setattr(reel, name, value)
    model = spec.compile()
    model.opt.disableflags |= int(flags)
    model.opt.disableactuator = disabled
    data = mujoco.MjData(model)
    for share in np.linspace(0.0, 1.0, 101):
        data.ctrl[:] = share * control
        mujoco.mj_step(model, data)
    shown = ("input_tension", "output_tension", "reel_displacement")
    return [data.sensor(name).data[0] for name in shown]


def ranged(**more):
    return {"ctrlrange": [0.0, 0.5 * CONTROL], "ctrllimited": 1, **more}


@pytest.mark.parametrize(
    ("attributes", "counts"),
    [
        ({"gear": [2.0, 0, 0, 0, 0, 0]}, 2.0),
        ({"gear": [-1.0, 0, 0, 0, 0, 0]}, -1.0),
        ({"gear": [0.0] * 6}, 0.0),
        (ranged(flags=FLAG.mjDSBL_CLAMPCTRL), 1.0),
        ({"flags": FLAG.mjDSBL_ACTUATION}, 0.0),
        ({"group": 2, "disabled": 1 << 2}, 0.0),
        ({"group": 1, "disabled": 1 << 2}, 1.0),
        ({"group": 31, "disabled": -1}, 1.0),  # which no bit disables
    ],
    ids=str,
)
def test_a_reel_winds_its_control_times_what_counts_of_it(attributes, counts):
    seen, plain = readings(**attributes), readings(counts * CONTROL)
    np.testing.assert_allclose(seen, plain, rtol=1e-12)
    assert seen[2] == pytest.approx(counts * CONTROL, rel=1e-12)


def test_a_gear_multiplies_what_its_range_leaves_of_the_control():
    seen = readings(**ranged(gear=[4.0, 0, 0, 0, 0, 0]))
    assert seen[2] == pytest.approx(2.0 * CONTROL, rel=1e-12)


def test_a_control_that_does_not_count_need_not_be_finite():
    assert readings(np.nan, flags=FLAG.mjDSBL_ACTUATION) == readings(0.0)
