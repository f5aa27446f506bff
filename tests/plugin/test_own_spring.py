"""What is written to the model acts: a tendon's own spring, and all else that a sheath reads."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_friction, view_sheath
from tendon_mj.errors import InvalidValueError
from tests.refusals import refusing
from tests.rigs import MUJOCO, simulated

ARM = """<mujoco><option timestep=".001" integrator="{integrator}" gravity="0 0 0"/><worldbody>
  <site name="a" pos="-.1 0 .02"/><site name="b" pos="-.03 0 .03"/>
  <body><joint name="one" axis="0 1 0" damping=".02" stiffness=".3"/>
    <geom type="capsule" fromto="0 0 0 .1 0 0" size=".01" contype="0" conaffinity="0"/>
    <site name="c" pos=".03 0 .03"/><site name="d" pos=".08 0 .02"/>
    <body pos=".11 0 0"><joint name="two" axis="0 1 0" damping=".02" stiffness=".3"/>
      <geom type="capsule" fromto="0 0 0 .08 0 0" size=".01" contype="0" conaffinity="0"/>
      <site name="e" pos=".04 0 .02"/>
  </body></body></worldbody>
  <tendon><spatial name="band" stiffness="200" springlength="{length}"><site site="a"/>
    <site site="b"/><site site="c"/><site site="d"/><site site="e"/></spatial></tendon>
  <sensor><tendonpos tendon="band"/></sensor></mujoco>"""


def spec(length="0.24", integrator="Euler"):
    return mujoco.MjSpec.from_string(ARM.format(length=length, integrator=integrator))


def follow(model, write, seconds=10.0):
    """(steps, nq) positions while ``write(model, time)`` changes the model in every step."""
    data, path = mujoco.MjData(model), []
    for _ in range(round(seconds / model.opt.timestep)):
        write(model, data.time)
        mujoco.mj_step(model, data)
        path.append(data.qpos.copy())
    return np.array(path)


def at_random(seed):
    """Writes a rest length, a stiffness and its polynomial that jump ten times a second."""
    rng = np.random.default_rng(seed)
    lengths, stiffnesses = rng.uniform(0.15, 0.26, 101), rng.uniform(20.0, 400.0, 101)

    def write(model, time):
        model.tendon_lengthspring[0] = lengths[int(time / 0.1)]
        model.tendon_stiffness[0] = stiffnesses[int(time / 0.1)]
        model.tendon_stiffnesspoly[0] = [2e3, 1e4] if time > 8.0 else [0.0, 0.0]

    return write


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize("spring", ["cable", "input"])
def test_without_friction_it_moves_as_without_a_sheath(integrator, spring):
    plain = spec(integrator=integrator).compile()
    rubbed = add_friction(spec(integrator=integrator), "band", friction=0.0, spring=spring)
    one, other = (follow(m, at_random(1)) for m in (plain, rubbed.compile()))
    assert np.ptp(one, axis=0).min() > 0.1
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)


def test_a_shorter_spring_is_tendon_wound_in_by_a_reel():
    """With EA = k S held, both are the same cable; on the reel it is under its pretension."""
    reeled = spec()
    add_friction(reeled, "band", friction=0.2, reel="reel")
    banded = add_friction(spec(), "band", friction=0.2)
    one, other = reeled.compile(), banded.compile()
    ea, laid = 200 * 0.24, 0.24 / one.tendon_length0[0]
    data, winch = mujoco.MjData(one), mujoco.MjData(other)
    for k in range(3000):
        drawn = 0.01 * (1.0 - np.cos(0.004 * k))  # always tight: a slack spring pushes
        data.ctrl[0] = drawn
        other.tendon_lengthspring[0] = 0.24 - laid * drawn
        other.tendon_stiffness[0] = ea / (0.24 - laid * drawn)
        mujoco.mj_step(one, data)
        mujoco.mj_step(other, winch)
    assert np.abs(data.qpos).min() > 0.01
    np.testing.assert_allclose(data.qpos, winch.qpos, rtol=0, atol=1e-9)


def test_the_band_keeps_its_stiffness_and_its_dead_zone():
    """The same as a sheath of stated EA and T_0 on a tendon without a spring."""
    model = add_friction(spec(), "band", friction=0.3).compile()
    bare = spec()
    bare.tendon("band").stiffness[:] = 0.0
    length = float(model.tendon_length0[0])
    stated = {"axial_stiffness": 200 * 0.24, "pretension": 200 * (length - 0.24)}
    other = add_friction(bare, "band", friction=0.3, **stated).compile()
    paths = []
    for m in (model, other):
        data = mujoco.MjData(m)
        for k in range(4000):
            data.qfrc_applied[:] = 0.04 * np.sin(0.004 * k)
            mujoco.mj_step(m, data)
            paths.append(data.qpos.copy())
    one, two = np.split(np.array(paths), 2)
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-10)
    assert np.ptp(one) > 0.02


def test_parameters_and_model_both_act_and_the_last_write_counts():
    model = add_friction(spec(), "band", friction=0.1, name="sheath").compile()
    data = mujoco.MjData(model)
    parameters = Parameters(model, data)
    length = float(model.tendon_length0[0])
    assert parameters["sheath.axial_stiffness"] == 200 * 0.24
    assert parameters["sheath.pretension"] == pytest.approx(200 * (length - 0.24))
    mujoco.mj_step(model, data)
    parameters["sheath.axial_stiffness"] = 96.0
    mujoco.mj_step(model, data)
    assert parameters["sheath.axial_stiffness"] == 96.0
    model.tendon_stiffness[0] *= 0.5
    mujoco.mj_step(model, data)
    assert parameters["sheath.axial_stiffness"] == pytest.approx(48.0)
    mujoco.mj_resetData(model, data)
    assert Parameters(model, data)["sheath.axial_stiffness"] == pytest.approx(0.5 * 200 * 0.24)


@pytest.mark.parametrize("written", ["stiffness", "flag"])
def test_a_spring_that_is_switched_off_pulls_nothing_and_comes_back(written):
    model = add_friction(spec(), "band", friction=0.1).compile()
    data = simulated(model, 10)
    view = view_sheath(model, data, "band")
    before = view.tension.copy()
    assert before.min() > 1.0
    if written == "flag":
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SPRING
    else:
        model.tendon_stiffness[0] = 0.0
    mujoco.mj_forward(model, data)
    assert view.tension.max() == 0.0
    assert not data.qfrc_passive[model.jnt_stiffness == 0].any()
    model.opt.disableflags = 0
    model.tendon_stiffness[0] = 200.0
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(view.tension, before, rtol=1e-2)
    assert view.unsolved == 0


def test_an_odd_spring_is_refused_as_a_cable_by_name():
    text = (
        add_friction(spec(), "band", friction=0.1)
        .to_xml()
        .replace('stiffness="200"', 'stiffness="200 5"')
    )
    with refusing(ValueError, "band", "200 5"):
        mujoco.MjModel.from_xml_string(text)
    with pytest.raises(InvalidValueError):
        add_friction(spec(), "band", friction=0.1, slack=-1.0)


def test_slack_is_drawn_in_before_the_tendon_pulls():
    """s = 5 mm: nothing until 5 mm are wound in, EA/S per metre behind that."""
    bare = spec()
    bare.tendon("band").stiffness[:] = 0.0
    given = {"axial_stiffness": 1000.0, "slack": 0.005, "reel": "reel"}
    model = add_friction(bare, "band", friction=0.0, **given).compile()
    model.jnt_stiffness[:] = 1e6
    data = mujoco.MjData(model)
    length = float(model.tendon_length0[0]) + 0.005
    for drawn in (0.0, 0.0049, 0.006, 0.008):
        data.ctrl[0] = drawn
        mujoco.mj_forward(model, data)
        meant = max(0.0, 1000.0 * (float(data.ten_length[0]) / (length - drawn) - 1.0))
        tension = view_sheath(model, data, "band").tension
        np.testing.assert_allclose(tension, meant, rtol=1e-9, atol=1e-9)


def at_random_elsewhere(model, time, rng):
    """Write sites, a gear, damping and the order of two guides, as programs do between steps."""
    model.site_pos[1:4] += rng.uniform(-1e-4, 1e-4, (3, 3))
    model.actuator_gear[:, 0] *= rng.uniform(0.99, 1.01)
    model.tendon_damping[0] = rng.uniform(0.0, 0.5)
    model.actuator_gainprm[:, 0] *= rng.uniform(0.99, 1.01)
    if rng.random() < 0.01:
        model.wrap_objid[[1, 2]] = model.wrap_objid[[2, 1]]


def test_a_driven_sheath_follows_whatever_is_written():
    """Without friction to the last bit, with it so that each step is that of the model as it is."""
    paths = []
    for sheathed in (False, True):
        drawn = pulled()
        if sheathed:
            add_friction(drawn, "band", friction=0.0)
        model, rng = drawn.compile(), np.random.default_rng(3)
        data = mujoco.MjData(model)
        for k in range(3000):
            data.ctrl[:] = 1.0 + np.sin(0.01 * k)
            at_random_elsewhere(model, data.time, rng)
            mujoco.mj_step(model, data)
            paths.append(data.qpos.copy())
    one, other = np.split(np.array(paths), 2)
    assert np.ptp(one) > 0.05
    np.testing.assert_array_equal(one, other)


def pulled():
    drawn = spec()
    drawn.tendon("band").stiffness[:] = 0.0
    motor = drawn.add_actuator(trntype=mujoco.mjtTrn.mjTRN_TENDON, target="band")
    motor.gear[0] = -2.0
    return drawn


def test_a_motor_that_is_written_away_leaves_a_tendon_that_pulls_nothing():
    drawn = pulled()
    add_friction(drawn, "band", friction=0.2)
    other = drawn.add_tendon(name="other")
    other.wrap_site("a")
    other.wrap_site("e")
    model = drawn.compile()
    data = simulated(model, 50, ctrl=1.0)
    model.actuator_trnid[0, 0] = model.tendon("other").id
    mujoco.mj_step(model, data, 500)
    assert np.isfinite(data.qpos).all()
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number == 0
    assert view_sheath(model, data, "band").unsolved == 500


@pytest.mark.skipif(MUJOCO < (4, 0), reason="springs of tendons yield from MuJoCo 4 on")
@pytest.mark.parametrize("drive", ["", '<actuator><motor tendon="band" gear="-1"/></actuator>'])
def test_a_spring_that_yields_is_refused(drive):
    text = ARM.format(length="0.24", integrator="Euler").replace("<sensor>", f"{drive}<sensor>")
    yielding = text.replace('stiffness="200"', 'stiffness="200" springyield="2"')
    sheath = add_friction(mujoco.MjSpec.from_string(yielding), "band", friction=0.1)
    with refusing(ValueError, "'band'", "springyield = 2 N"):
        sheath.compile()
