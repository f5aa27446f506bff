"""Another package's code puts models with sheaths, once it takes them, and others as before."""

import types
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import tendon_mj
from tendon_mj.errors import InvalidValueError, NoPluginsError, UnknownNameError, UnusedKeyError
from tests.refusals import refusing
from tests.warp.models import controls, fingers, fingers_xml, mjw, step, tw

wp = pytest.importorskip("warp")

PLAIN = "<mujoco><worldbody><body><joint/><geom size='.1'/></body></worldbody></mujoco>"


def a_host():
    """A module that puts models as mjlab's does."""
    host = types.ModuleType("host")
    source = """
def start(model, data, worlds):
    return mjwarp.put_model(model), mjwarp.put_data(model, data, nworld=worlds)

def reset(m, d, worlds=None):
    mjwarp.reset_data(m, d, reset=worlds)
"""
    host.mjwarp = mjw
    exec(source, vars(host))
    return host


def test_a_host_that_takes_sheaths_simulates_what_this_package_does():
    model, host = fingers(kinds=("drum",)), a_host()
    tw.take_sheaths(host)
    m, d = host.start(model, mujoco.MjData(model), 2)
    other_m, other = tw.put_model(model), tw.make_data(model, 2)
    for row in controls(model, 5):
        step(m, d, row)
        step(other_m, other, row)
    np.testing.assert_array_equal(d.qpos.numpy(), other.qpos.numpy())
    assert (tw.sheaths_of(d).input_tension.numpy() > 0.0).all()
    tw.sheaths_of(d).set("friction", np.array([[0.3], [0.1]]))
    host.reset(m, d)
    np.testing.assert_allclose(tw.sheaths_of(d).parameters["friction"].numpy()[:, 0], [0.3, 0.1])


@pytest.mark.parametrize("steps", [1, 7])
def test_worlds_that_a_host_resets_are_as_in_a_fresh_environment(steps):
    model, host = fingers(kinds=("drum",)), a_host()
    tw.take_sheaths(host)
    (m, d), (_, fresh) = (host.start(model, mujoco.MjData(model), 8) for _ in range(2))
    rows = controls(model, 30)[10:]
    for row in rows[:steps]:
        step(m, d, row)
    worlds = np.isin(np.arange(8), [2, 5])
    host.reset(m, d, wp.array(worlds, dtype=wp.bool))
    for row in rows[::-1]:
        step(m, d, row)
        step(m, fresh, row)
    same = (d.qpos.numpy() == fresh.qpos.numpy()).all(axis=1)
    np.testing.assert_array_equal(same, worlds)


def test_a_model_without_sheaths_is_put_as_before():
    model, host = mujoco.MjModel.from_xml_string(PLAIN), a_host()
    tw.take_sheaths(host)
    m, d = host.start(model, mujoco.MjData(model), 2)
    mjw.step(m, d)
    host.reset(m, d)
    assert d.time.numpy().tolist() == [0.0, 0.0]


def test_a_host_gets_its_own_functions_back():
    model, host = fingers(kinds=("drum",)), a_host()
    tw.take_sheaths(host)
    give_back = tw.take_sheaths(host)  # which it does already
    assert host.mjwarp.step is mjw.step
    give_back()
    assert host.mjwarp is mjw
    with pytest.raises(NotImplementedError, match="mjSENS_PLUGIN"):
        host.start(model, mujoco.MjData(model), 1)


def driven_spec(sheaths=True, more=""):
    """A finger of two joints with sensors of force, whose tendon a motor pulls."""
    text = fingers_xml(kinds=("drum",))
    tree = ElementTree.fromstring(text)
    sensors = tree.find("sensor")
    for plugin in sensors.findall("plugin"):
        sensors.remove(plugin)
    tree.remove(tree.find("extension"))
    spec = mujoco.MjSpec.from_string(
        ElementTree.tostring(tree, "unicode").replace("</mujoco>", more + "</mujoco>")
    )
    return tendon_mj.add_friction(spec, "drum", friction=0.2) if sheaths else spec


def test_sheaths_on_a_model_that_is_on_the_device_act_as_in_one_that_was_put_with_them():
    model, plain = driven_spec().compile(), driven_spec(sheaths=False).compile()
    host_m, host_d = mjw.put_model(plain), mjw.make_data(plain, 2)
    tw.put_sheaths(model, host_m, host_d)
    m, d = tw.put_model(model), tw.make_data(model, 2)
    for data in (host_d, d):
        tw.sheaths_of(data).set("friction", np.array([[0.3], [0.1]]))
    for row in controls(model, 20):
        step(host_m, host_d, row)
        step(m, d, row)
    np.testing.assert_array_equal(host_d.qpos.numpy(), d.qpos.numpy())
    own = host_d.sensordata.shape[1]  # of force and torque, with the reactions of sheaths
    np.testing.assert_array_equal(host_d.sensordata.numpy(), d.sensordata.numpy()[:, :own])
    lost = tw.sheaths_of(host_d).output_tension.numpy()
    np.testing.assert_array_equal(lost, tw.sheaths_of(d).output_tension.numpy())
    assert lost[0, 0] < lost[1, 0]
    worlds = wp.array([True, False], dtype=wp.bool)
    tw.reset_data(host_m, host_d, worlds)
    tw.reset_data(m, d, worlds)
    step(host_m, host_d, row)
    step(m, d, row)
    np.testing.assert_array_equal(host_d.qpos.numpy(), d.qpos.numpy())


ANOTHER = '<worldbody><body pos="0 0 1"><joint/><geom size=".1"/></body></worldbody>'


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        (lambda m, d, plain: setattr(m.callback, "passive", print), "callbacks | passive"),
        (lambda m, d, plain: setattr(m, "nsensordata", 5), "data are not of the model"),
        (lambda m, d, plain: m.wrap_objid.assign(m.wrap_objid.numpy()[::-1].copy()), "paths"),
    ],
    ids=["callbacks", "sizes", "paths"],
)
def test_sheaths_on_what_does_not_take_them_are_refused_and_nothing_is_changed(change, facts):
    plain = driven_spec(sheaths=False).compile()
    m, d = mjw.put_model(plain), mjw.make_data(plain, 1)
    change(m, d, plain)
    with refusing(InvalidValueError, "put_sheaths", facts):
        tw.put_sheaths(driven_spec().compile(), m, d)
    assert m.callback.act_bias is None
    assert not hasattr(d, "tendon_mj")


def test_options_on_the_device_are_those_that_act():
    model, plain = driven_spec().compile(), driven_spec(sheaths=False).compile()
    plain.opt.timestep = 0.25 * model.opt.timestep
    plain.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    host_m, host_d = mjw.put_model(plain), mjw.make_data(plain, 1)
    tw.put_sheaths(model, host_m, host_d)
    model.opt.timestep, model.opt.integrator = plain.opt.timestep, plain.opt.integrator
    m, d = tw.put_model(model), tw.make_data(model, 1)
    for row in controls(model, 10):
        step(host_m, host_d, row)
        step(m, d, row)
    np.testing.assert_array_equal(host_d.qpos.numpy(), d.qpos.numpy())
    host_m.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP.value
    with refusing(NoPluginsError, "sleep"):
        mjw.passive(host_m, host_d)


def test_another_model_is_refused_by_the_sizes_that_differ():
    plain = driven_spec(sheaths=False, more=ANOTHER).compile()
    m, d = mjw.put_model(plain), mjw.make_data(plain, 1)
    with refusing(InvalidValueError, "nq is 3 on the device and 2 with sheaths", "take_sheaths"):
        tw.put_sheaths(driven_spec().compile(), m, d)
    with refusing(InvalidValueError, "no sheaths", "add_friction"):
        tw.put_sheaths(plain, m, d)


def test_sensors_behind_those_of_sheaths_are_refused():
    spec = driven_spec()
    spec.add_sensor(
        name="late",
        type=mujoco.mjtSensor.mjSENS_JOINTPOS,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        objname="drum_one",
    )
    plain = driven_spec(
        sheaths=False, more='<sensor><jointpos name="late" joint="drum_one"/></sensor>'
    ).compile()
    m, d = mjw.put_model(plain), mjw.make_data(plain, 1)
    with refusing(InvalidValueError, "put_sheaths", "sensors", "last"):
        tw.put_sheaths(spec.compile(), m, d)


@pytest.fixture
def environment():
    """An environment as mjlab's, of four worlds with two tendons, and its sheaths."""
    pytest.importorskip("torch")
    model = fingers(kinds=("reel", "drum"))
    data = tw.make_data(model, 4)
    return types.SimpleNamespace(sim=types.SimpleNamespace(wp_data=data)), tw.sheaths_of(data)


def test_an_event_draws_parameters_of_given_worlds_and_sheaths(environment):
    env, sheaths = environment
    torch = pytest.importorskip("torch")
    before = {name: table.numpy().copy() for name, table in sheaths.parameters.items()}
    ranges = {"*.friction": (0.3, 0.4), "drum.extra_bend": (1.0, 2.0), "reel.pretension": (6, 7)}
    ranges["*.static_friction"] = (0.5, 0.5)
    tw.draw_parameters(env, torch.tensor([1, 3]), ranges)
    after = {name: table.numpy() for name, table in sheaths.parameters.items()}
    drawn = [("friction", [0, 1]), ("extra_bend", [1]), ("pretension", [0])]
    for (parameter, columns), (low, high) in zip(drawn, ranges.values(), strict=False):
        table, old = after[parameter], before[parameter]
        part = table[np.ix_([1, 3], columns)]
        assert ((part >= low) & (part <= high)).all()
        assert np.unique(part).size == part.size
        rest = np.ones(table.shape, bool)
        rest[np.ix_([1, 3], columns)] = False
        np.testing.assert_array_equal(table[rest], old[rest])
    np.testing.assert_array_equal(after["static_friction"][[1, 3]], 0.5)
    tw.draw_parameters(env, None, {"*.friction": (0.1, 0.2)}, shared_random=True)
    friction = sheaths.parameters["friction"].numpy()
    np.testing.assert_array_equal(friction[:, 0], friction[:, 1])
    assert np.unique(friction[:, 0]).size == 4


def test_an_event_scales_and_adds_to_what_the_model_has_however_often_it_draws(environment):
    env, sheaths = environment
    static = sheaths.parameters["static_friction"].numpy().copy()
    for _ in range(3):
        tw.draw_parameters(env, None, {"*.friction": (2.0, 2.0)}, operation="scale")
        ranges = {"*.static_friction": (0.25, 0.25)}
        tw.draw_parameters(env, None, ranges, distribution="log_uniform", operation="add")
    friction = sheaths.parameters["friction"].numpy()
    np.testing.assert_allclose(friction, [[0.4, 0.3]] * 4, rtol=1e-6)  # 0.2 and 0.15
    np.testing.assert_allclose(
        sheaths.parameters["static_friction"].numpy(), static + 0.25, rtol=1e-6
    )


def test_an_event_draws_numbers_whose_logarithm_is_uniform():
    pytest.importorskip("torch").manual_seed(1)
    model = fingers(kinds=("reel",))
    data = tw.make_data(model, 4000)
    env = types.SimpleNamespace(sim=types.SimpleNamespace(wp_data=data))
    tw.draw_parameters(env, None, {"*.friction": (0.01, 1.0)}, distribution="log_uniform")
    drawn = np.log10(tw.sheaths_of(data).parameters["friction"].numpy())
    assert drawn.mean() == pytest.approx(-1.0, abs=4 * 2 / np.sqrt(12 * 4000))
    assert drawn.std() == pytest.approx(2 / np.sqrt(12), rel=0.05)


def test_terms_of_a_scene_mean_the_sheaths_of_its_tendons(environment):
    env, sheaths = environment
    sheaths.tendon_names = ("robot/reel", "robot/drum")  # as in a scene
    before = sheaths.parameters["friction"].numpy().copy()
    drum = types.SimpleNamespace(name="robot", tendon_names=["drum"])
    tw.draw_parameters(env, None, {"friction": (0.5, 0.5)}, drum)
    friction = sheaths.parameters["friction"].numpy()
    np.testing.assert_array_equal(friction, np.column_stack([before[:, 0], [0.5] * 4]))
    sheaths.input_tension.assign(np.tile([[1.0, 2.0]], (4, 1)))
    sheaths.output_tension.assign(np.tile([[3.0, 4.0]], (4, 1)))
    assert tw.tension(env, "input").tolist() == [[1.0, 2.0]] * 4
    assert tw.tension(env, asset_cfg=drum).tolist() == [[4.0]] * 4
    whole = types.SimpleNamespace(name="robot", tendon_names=None)
    assert tw.tension(env, asset_cfg=whole).tolist() == [[3.0, 4.0]] * 4
    drum.tendon_names = ["drums"]
    with refusing(UnknownNameError, "robot/drums | robot/drum"):
        tw.tension(env, asset_cfg=drum)
    with refusing(InvalidValueError, "middle", "input, output"):
        tw.tension(env, "middle")


@pytest.mark.parametrize(
    ("options", "facts"),
    [
        ({"distribution": "gaussian"}, "gaussian | uniform, log_uniform"),
        ({"operation": "multiply"}, "multiply | abs, scale, add"),
        ({"distribution": "log_uniform"}, "log_uniform | above 0"),
    ],
)
def test_another_way_to_draw_is_refused(environment, options, facts):
    env, _ = environment
    with refusing(InvalidValueError, facts):
        tw.draw_parameters(env, None, {"*.friction": (0.0, 0.2)}, **options)


@pytest.mark.parametrize(
    ("key", "span", "kind", "facts"),
    [
        ("*.friction", (-0.1, 0.2), InvalidValueError, "friction | -0.1"),
        ("*.friction", (0.3, 0.2), InvalidValueError, "friction | 0.3 | 0.2"),
        ("tendon.friction", (0.1, 0.2), UnknownNameError, "tendon | drum"),
        ("*.backlash", (0.0, 1e-3), UnknownNameError, "backlash"),
        ("*.pretension", (1.0, 2.0), UnusedKeyError, "drum.pretension"),
    ],
)
def test_an_event_that_cannot_be_is_refused(environment, key, span, kind, facts):
    env, sheaths = environment
    with refusing(kind, facts):
        tw.draw_parameters(env, None, {key: span})
    assert np.unique(sheaths.parameters["friction"].numpy()).tolist() == pytest.approx([0.15, 0.2])


def test_what_does_not_call_mujoco_warp_is_refused():
    with refusing(InvalidValueError, "numpy", "no attribute that is the module mujoco_warp"):
        tw.take_sheaths(np)
