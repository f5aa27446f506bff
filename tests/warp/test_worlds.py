"""Worlds are independent: each is what it is alone, to the bit, and is reset alone."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tests.refusals import refusing
from tests.warp.models import controls, fingers, mjw, step, tw

wp = pytest.importorskip("warp")

from tendon_mj.warp.support import simulated_sheaths  # noqa: E402
from tendon_mj.warp.transfer import COMMITTED  # noqa: E402

KINDS = ("reel", "drum")
FRICTION = np.array([0.0, 0.1, 0.35])
STEPS = 15


@pytest.fixture(scope="module")
def model():
    return fingers(kinds=KINDS)


@pytest.fixture(scope="module")
def on_device(model):
    return tw.put_model(model)


def state(d):
    """All that a world shows of itself, a row for each."""
    sheaths = tw.sheaths_of(d)
    parts = (d.qpos, d.qvel, d.sensordata, sheaths.tension, sheaths.unsolved)
    return np.concatenate([part.numpy() for part in parts], axis=1)


def run(m, d, inputs, steps=STEPS):
    for k in range(steps):
        step(m, d, inputs[k])
    return state(d)


def alone(model, m, friction, inputs, steps=STEPS):
    """State of one world that runs alone."""
    d = tw.make_data(model)
    tw.sheaths_of(d).set("friction", friction)
    return run(m, d, inputs, steps)[0]


def test_each_world_with_friction_of_its_own_is_as_it_is_alone(model, on_device):
    inputs = controls(model, STEPS)
    d = tw.make_data(model, len(FRICTION))
    tw.sheaths_of(d).set("friction", FRICTION[:, None])
    together = run(on_device, d, inputs)
    for row, friction in zip(together, FRICTION, strict=True):
        assert (row == alone(model, on_device, friction, inputs)).all()
    assert np.ptp(together[:, : model.nq], axis=0).max() > 1e-5  # friction does something


def test_each_world_with_a_spring_of_its_own_is_as_it_is_alone():
    model = fingers(kinds=("cable",))
    inputs, rests = controls(model, STEPS), np.array([0.48, 0.46, 0.44], np.float32)

    def tied(rests):
        m, d = tw.put_model(model), tw.make_data(model, len(rests))
        m.tendon_lengthspring = wp.array(np.stack([rests] * 2, axis=-1)[:, None], dtype=wp.vec2)
        return run(m, d, inputs)

    together = tied(rests)
    for row, rest in zip(together, rests, strict=True):
        assert (row == tied(rest[None])[0]).all()
    assert np.ptp(together[:, : model.nq], axis=0).min() > 1e-4


def test_a_world_that_is_reset_is_as_it_was_at_first_and_the_others_go_on(model, on_device):
    inputs = controls(model, 2 * STEPS)
    d = tw.make_data(model, 2)
    run(on_device, d, inputs)
    tw.reset_data(on_device, d, wp.array([True, False], dtype=wp.bool))
    run(on_device, d, np.stack([inputs[:STEPS], inputs[STEPS:]], axis=1))
    first, second = state(d)
    fresh, long = tw.make_data(model), tw.make_data(model)
    assert (first == run(on_device, fresh, inputs)[0]).all()
    assert (second == run(on_device, long, inputs, 2 * STEPS)[0]).all()


@pytest.mark.parametrize("diverges", [False, True])
def test_a_reset_by_mujoco_warp_alone_is_noticed(model, on_device, diverges):
    inputs = controls(model, STEPS)
    d = tw.make_data(model)
    first = run(on_device, d, inputs)
    if diverges:
        d.qpos.fill_(float("nan"))
        mjw.step(on_device, d)
    mjw.reset_data(on_device, d)
    assert (run(on_device, d, inputs) == first).all()


def test_a_step_waits_for_nothing(model, on_device, monkeypatch):
    """So that it can be captured in a CUDA graph."""
    d = tw.make_data(model, 2)
    inputs = controls(model, 3)
    step(on_device, d, inputs[0])

    def waits(*_, **__):
        raise AssertionError("the host waits for the device")

    monkeypatch.setattr(wp.array, "numpy", waits)
    monkeypatch.setattr(wp, "synchronize", waits)
    mjw.step(on_device, d)
    monkeypatch.undo()
    assert d.time.numpy() == pytest.approx(2.0 * model.opt.timestep)


def test_parameters_are_checked_and_named(model):
    sheaths = tw.sheaths_of(tw.make_data(model, 3))
    assert sheaths.names == KINDS
    sheaths.set("constant_friction", [0.0, 1.0, 2.0], "drum")
    assert sheaths.parameters["constant_friction"].numpy()[:, 1].tolist() == [0.0, 1.0, 2.0]
    sheaths.set("pretension", 10.0, "reel")
    for given, said in (
        (("frictoin", 0.1), "did you mean 'friction'"),
        (("friction", 0.1, "flexor"), "sheath 'flexor'"),
        (("friction", -0.1), "friction"),
        (("friction", [0.1, 0.2], "drum"), "(2,) are not of shape (3,)"),
        (("friction", [0.1, 0.2, 0.3]), "values[:, None]"),
        (("friction", "much"), "friction | 'much'"),
        (("pretension", 10.0, "drum"), "drum.pretension has no meaning where"),
        (("pretension", 10.0), "drum.pretension has no meaning where"),
    ):
        with refusing((InvalidValueError, UnknownNameError), said):
            sheaths.set(*given)
    sheaths.set("friction", 0.3, sheaths.tendon_names[0])
    assert sheaths.parameters["friction"].numpy()[:, 0] == pytest.approx(0.3)
    sheaths = tw.sheaths_of(tw.make_data(fingers(kinds=("cable",))))
    with refusing(InvalidValueError, "cable.pretension | tendon_lengthspring"):
        sheaths.set("pretension", 10.0)


def test_a_world_that_is_got_back_goes_on_as_it_does_there(model, on_device):
    inputs = controls(model, 2 * STEPS)
    d = tw.make_data(model, 2)
    sheaths = tw.sheaths_of(d)
    sheaths.set("friction", FRICTION[:2, None])
    run(on_device, d, inputs[:STEPS])
    data = mujoco.MjData(model)
    Parameters(model, data)["reel.viscous_friction"] = 0.5  # which no world has
    tw.get_data_into(data, model, d, world_id=1)
    assert Parameters(model, data)["reel.viscous_friction"] == 0.0
    expected = run(on_device, d, inputs[STEPS:])[1]
    for row in inputs[STEPS:]:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos, expected[: model.nq], rtol=1e-3, atol=1e-4)
    assert Parameters(model, data)["reel.friction"] == pytest.approx(FRICTION[1])


def test_what_is_put_there_and_got_back_has_not_changed():
    model = fingers(kinds=(*KINDS, "cable", "limit"))
    data, again = mujoco.MjData(model), mujoco.MjData(model)
    for row in controls(model, STEPS):
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    tw.get_data_into(again, model, tw.put_data(model, data, 2), 1)
    result, expected = (simulated_sheaths(model, each) for each in (again, data))
    for name, sheath in expected.items():
        for part, field in (
            ("segments", "stored"),
            ("segments", "previous_tension"),
            ("guides", "previous_slip"),
            *(("state", name) for name in COMMITTED),
            ("state", "law"),
        ):
            assert (getattr(result[name], part)[field] == getattr(sheath, part)[field]).all()


def test_data_of_another_model_or_world_are_refused_by_what_would_use_them(model, on_device):
    other, plain = fingers(kinds=("drum", "reel")), mujoco.MjModel.from_xml_string("<mujoco/>")
    d, mine, data = tw.make_data(other), tw.make_data(model, 2), mujoco.MjData(model)
    uses = (mjw.step, mjw.forward, tw.reset_data)
    for use, said in (
        *((lambda use=use: use(on_device, d), "of another model, drum, reel") for use in uses),
        (lambda: tw.get_data_into(data, model, d), "of another model, drum, reel"),
        (lambda: tw.get_data_into(mujoco.MjData(plain), plain, mine), "of another model than is"),
        (lambda: tw.get_data_into(mujoco.MjData(plain), model, mine), ""),
        (lambda: tw.put_data(model, mujoco.MjData(plain)), ""),
        (lambda: tw.get_data_into(data, model, mine, -1), "world_id = -1 | from 0 to 1"),
        (lambda: tw.get_data_into(data, model, mine, 2), "world_id = 2 | from 0 to 1"),
        (lambda: tw.make_data(on_device), "give the mujoco.MjModel"),
        (lambda: tw.put_model(on_device), "give the mujoco.MjModel"),
        (lambda: tw.sheaths_of(mjw.make_data(plain)), "make_data"),
    ):
        with refusing(InvalidValueError, said):
            use()
