"""A sheath on a tendon that MuJoCo's own actuators and springs pull on."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_friction, view_sheath
from tests.refusals import refusing
from tests.rigs import (
    GIVEN,
    compiled,
    rope,
    sheath_view,
    sheathed,
    spatial,
    stock,
    two_links,
)

ACTUATORS = {
    "motor": '<motor tendon="t" gear="2" ctrlrange="-20 0"/>',
    "limited": '<motor tendon="t" ctrlrange="-30 0" forcerange="-9 0"/>',
    "position": '<position tendon="t" kp="300" dampratio="1" ctrlrange="0.3 0.5"/>',
    "velocity": '<velocity tendon="t" kv="40" ctrlrange="-1 0"/>',
    "muscle": '<muscle tendon="t" force="60" lengthrange="0.3 0.6" ctrlrange="0 1"/>',
    "general": '<general tendon="t" gainprm="-15" biastype="affine" biasprm="-4 0 -3" '
    'dyntype="filter" dynprm="0.03" ctrlrange="0 1"/>',
    "two": '<motor tendon="t" ctrlrange="-8 0"/><muscle tendon="t" force="40" '
    'lengthrange="0.3 0.6" ctrlrange="0 1"/>',
}
SPRING = 'stiffness="60" springlength="0.3" damping="0.4"'
SLACK_SPRING = 'stiffness="60" springlength="0.2 0.4"'  # pulls beyond 0.4 m only


def arm(actuator="", friction=None, tendon="", path="a b c d", option='timestep="0.001"', **law):
    """Two links, pulled by a tendon over two bends."""
    law = None if friction is None else {"friction": friction} | law
    return compiled(two_links(path, tendon=tendon, law=law, actuator=actuator, option=option))


def controls(model, seconds=1.0, seed=0):
    """Smooth random controls, (steps, nu)."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds / model.opt.timestep)) * model.opt.timestep
    low, high = model.actuator_ctrlrange.T
    rates, phases = rng.uniform(0.5, 3.0, (3, model.nu)), rng.uniform(0.0, 6.0, (3, model.nu))
    waves = np.sin(rates[:, None] * time[:, None] * 6.28 + phases[:, None]).mean(0)
    return low + (high - low) * (0.5 + 0.5 * waves)


def run(model, inputs):
    """Positions and sensors at every step, and the data at the end."""
    data = mujoco.MjData(model)
    positions, sensors = [], []
    for row in inputs:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
        positions.append(data.qpos.copy())
        sensors.append(data.sensordata.copy())
    return np.array(positions), np.array(sensors), data


@pytest.mark.parametrize("tendon", ["", SPRING, SLACK_SPRING])
@pytest.mark.parametrize("actuator", ACTUATORS.values(), ids=ACTUATORS)
def test_without_friction_the_model_moves_as_mujocos_own(actuator, tendon):
    stock = arm(actuator, tendon=tendon)
    inputs = controls(stock)
    expected, _, _ = run(stock, inputs)
    actual, sensors, _ = run(arm(actuator, friction=0.0, tendon=tendon), inputs)
    assert np.array_equal(actual, expected)
    assert np.array_equal(sensors[:, 0], sensors[:, 1])


@pytest.mark.parametrize("stiffness", [None, 1e3, 1e5, 1e7])
@pytest.mark.parametrize("actuator", ACTUATORS.values(), ids=ACTUATORS)
def test_friction_holds_tension_back_takes_energy_and_changes_the_motion(actuator, stiffness):
    """e^{−μφ} ≤ T_out/T_in ≤ e^{μφ}, and the friction work of no guide ever falls."""
    law = {"friction": 0.3, "axial_stiffness": stiffness, "option": 'timestep="0.002"'}
    model = arm(actuator, **law)
    inputs = controls(model)
    data, before = mujoco.MjData(model), np.zeros(2)
    for row in inputs:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
        guides = sheath_view(model, data).guides
        bend, work = 0.3 * guides["angle"].sum(), guides["friction_work"].copy()
        tension_in, tension_out = data.sensordata
        assert tension_in * np.exp(-bend) <= tension_out * (1.0 + 1e-9) + 1e-9
        assert tension_out <= tension_in * np.exp(bend) * (1.0 + 1e-9) + 1e-9
        assert (work >= before).all()
        before = work
    assert before.sum() > 1e-3
    free = run(arm(actuator, **law | {"friction": 0.0}), inputs)[2]
    assert np.abs(free.qpos - data.qpos).max() > 1e-3


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast", "RK4"])
@pytest.mark.parametrize(
    ("tendon", "slack", "damping"), [(SPRING, 0.3, 0.4), (SLACK_SPRING, 0.4, 0.0)]
)
@pytest.mark.parametrize("actuators", [ACTUATORS["two"], ""])
def test_the_input_tension_is_the_actuators_force(actuators, tendon, slack, damping, integrator):
    """With the tendon's own spring and damper, and theirs where there is no actuator."""
    model = arm(actuators, 0.3, tendon, option=f'timestep="0.001" integrator="{integrator}"')
    data = mujoco.MjData(model)
    for row in controls(model, 0.3):
        data.ctrl[:] = row
        mujoco.mj_forward(model, data)
        spring = -60.0 * max(0.0, data.ten_length[0] - slack) - damping * data.ten_velocity[0]
        force = data.actuator_force.sum() + spring
        assert data.sensordata[0] == pytest.approx(max(0.0, -force), rel=1e-9, abs=1e-9)
        mujoco.mj_step(model, data)


def test_an_actuator_that_pushes_passes_the_sheath_unrubbed():
    push = '<motor tendon="t" ctrlrange="-5 5"/>'
    stock, rubbed = arm(push), arm(push, friction=0.6)
    inputs = np.full((400, 1), 3.0)
    expected, actual = run(stock, inputs), run(rubbed, inputs)
    assert np.array_equal(expected[0], actual[0])
    assert not actual[1].any()


@pytest.mark.parametrize("flag", ["actuation", "spring", "damper"])
def test_what_is_disabled_does_not_pull(flag):
    option = f'timestep="0.001"><flag {flag}="disable"/></option><option'
    stock = arm(ACTUATORS["two"], tendon=SPRING, option=option)
    inputs = controls(stock, 0.3)
    actual, _, data = run(arm(ACTUATORS["two"], 0.0, SPRING, option=option), inputs)
    assert np.array_equal(actual, run(stock, inputs)[0])
    if flag == "actuation":
        mujoco.mj_forward(data.model, data)
        pull = 60.0 * max(0.0, data.ten_length[0] - 0.3) + 0.4 * data.ten_velocity[0]
        assert data.sensordata[0] == pytest.approx(max(0.0, pull), rel=1e-9)


def held(count, step):
    """MJCF of a slide on a spring that ``count`` tendons pull."""
    ends = [f"a{i} 0 {0.02 * i} .3; b{i} .5 {0.02 * i} 0" for i in range(count)]
    tendons = [(f"t{i}", f"a{i} b{i} c{i}") for i in range(count)]
    return rope(
        "; ".join(ends),
        "; ".join(f"c{i} 0 {0.02 * i} 0" for i in range(count)),
        tendons[0][1],
        name="t0",
        tendons="".join(spatial(name, words) for name, words in tendons[1:]),
        body='pos="1 0 0"',
        joint='name="j" type="slide" axis="1 0 0" stiffness="2000" damping="60"',
        geom='size=".03" mass="1"',
        option=f'timestep="{step}" gravity="0 0 0"',
        actuator="".join(f'<motor tendon="{name}"/>' for name, _ in tendons),
    )


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@pytest.mark.parametrize("stiffness", [1e3, 1e5, 1e7])
@pytest.mark.parametrize("step", [2e-3, 5e-4])
@pytest.mark.parametrize("count", [1, 8])
def test_elastic_tendons_hold_a_load_together_however_stiff_they_are(stiffness, step, count):
    """Also when the stiffness becomes that only while they hold it."""
    spec = mujoco.MjSpec.from_string(held(count, step))
    model = add_friction(spec, "*", friction=0.4, axial_stiffness=1e3).compile()
    data = mujoco.MjData(model)
    data.ctrl[:], data.qpos[0] = -20.0 / count, -1.05 * 20.0 / 2000.0
    mujoco.mj_step(model, data, 20)
    parameters = Parameters(model, data)
    for name in (name for name in parameters if name.endswith("axial_stiffness")):
        parameters[name] = stiffness
    views = [view_sheath(model, data, f"t{i}") for i in range(count)]
    mujoco.mj_step(model, data, 4000)
    work, outputs = sum(view.friction_work.sum() for view in views), []
    for _ in range(50):
        mujoco.mj_step(model, data)
        outputs.append(sum(float(view.output_tension) for view in views))
    assert np.ptp(outputs) < 1e-6
    assert outputs[-1] == pytest.approx(-2000.0 * data.qpos[0], rel=1e-6)
    assert sum(view.friction_work.sum() for view in views) - work < 1e-12


def test_it_converges_to_the_same_motion_from_any_stiffness_above():
    inputs = controls(arm(ACTUATORS["motor"]), 1.0)

    def motion(stiffness, parts):
        option = f'timestep="{0.001 / parts}"'
        model = arm(ACTUATORS["motor"], 0.3, axial_stiffness=stiffness, option=option)
        return run(model, np.repeat(inputs, parts, axis=0))[0][parts - 1 :: parts]

    fine = motion(None, 8)
    for stiffness in (1e5, 1e6, 1e7, None):
        error = np.abs(motion(stiffness, 1) - fine).max() / np.ptp(fine)
        assert error < 0.02


REEL = '<plugin name="r" plugin="tendon_mj.sheath" instance="s" tendon="t"/>'
WINDING = (
    "pretension", "viscous_friction", "tendon_mass", "backlash", "sheath_compliance",
    "output_compliance",
)  # fmt: skip


@pytest.mark.parametrize(
    ("actuators", "law", "facts"),
    [
        *((ACTUATORS["motor"], {extra: 5}, [f"{extra} = 5"]) for extra in WINDING),
        ("", {}, ["axial_stiffness"]),  # where nothing pulls
        (f'<motor name="m" tendon="t"/>{REEL}', {"axial_stiffness": 1e4}, ["'m'", "reel"]),
    ],
)
def test_a_drive_that_the_law_does_not_fit_is_refused(actuators, law, facts):
    with refusing(ValueError, "instance 's'", *facts):
        arm(actuators, 0.3, **law)


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")  # of muscles over two sites
@pytest.mark.parametrize("name", GIVEN)
def test_without_friction_models_of_others_move_as_they_do(name):
    plain, model = stock(name), sheathed(name, friction=0.0)
    inputs = controls(plain, 2.0)
    expected, actual = run(plain, inputs)[0], run(model, inputs)[0]
    assert np.isfinite(actual).all()
    np.testing.assert_array_equal(actual, expected)


def test_a_slack_tendon_at_rest_does_not_slip():
    spec = mujoco.MjSpec.from_string(
        """<mujoco><worldbody><site name="a" pos="0 0 .1"/><site name="b" pos=".07 0 -.05"/>
        <body pos=".02 0 -.1"><joint name="j" axis="0 1 0" damping=".5" stiffness="1"/>
        <geom size=".02" pos="0 0 -.2" mass="1"/><site name="c" pos=".05 0 -.02"/>
        <site name="d" pos=".03 0 -.1"/><site name="e" pos="0 0 -.15"/></body></worldbody>
        <tendon><spatial name="t"><site site="a"/><site site="b"/><site site="c"/><site site="d"/>
        <site site="e"/></spatial></tendon>
        <actuator><motor tendon="t" ctrlrange="-50 0"/></actuator></mujoco>"""
    )
    model = add_friction(spec, "t", friction=0.2).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = -20.0
    mujoco.mj_step(model, data, 500)
    data.ctrl[:] = 0.0
    mujoco.mj_step(model, data, 60)
    assert view_sheath(model, data, "t").slip.any()  # it still moves
    mujoco.mj_step(model, data, 20000)
    assert abs(data.qvel[0]) < 1e-9
    assert not view_sheath(model, data, "t").slip.any()


TWO_TREES = """<mujoco><option timestep="0.005" integrator="{}" gravity="0 0 0"/>
  <default><geom size=".05" pos=".1 0 0" mass="1"/></default>
  <worldbody><site name="s0" pos="-.2 0 .1"/><site name="s1" pos="0 0 .1"/>
    <body><joint name="a" axis="0 1 0"/><geom/><site name="s2" pos=".1 0 0"/></body>
    <body pos="0 1 0"><joint name="b" axis="0 1 0"/><geom/></body></worldbody>
  <tendon><spatial name="t"><site site="s0"/><site site="s1"/><site site="s2"/></spatial>
    <fixed name="both"><joint joint="a" coef="1"/><joint joint="b" coef="-.7"/></fixed></tendon>
  <actuator><motor tendon="t" gear="-1"/>
    <general tendon="both" biastype="affine" biasprm="0 0 -.4"/></actuator></mujoco>"""


def beside_a_damper(text, integrator):
    """The model of a rig with friction on its cable."""
    spec = mujoco.MjSpec.from_string(text.format(integrator))
    return add_friction(spec, "t", friction=0.3, extra_bend=3.0, inner_guides=4).compile()


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast"])
def test_friction_holds_beside_a_damper_between_two_trees_of_bodies(integrator):
    """MuJoCo integrates implicitly only what such a damper does within a tree."""
    model = beside_a_damper(TWO_TREES, integrator)
    data, fastest = mujoco.MjData(model), 0.0
    data.ctrl[0] = 20.0
    for k in range(400):
        data.qfrc_applied[:] = 1.5 + 0.2 * np.sin(0.1 * k), 0.5 * np.sin(0.15 * k)
        mujoco.mj_step(model, data)
        assert abs(data.qvel[0]) < 1e-12
        fastest = max(fastest, abs(data.qvel[1]))
    assert fastest > 1.0


FREE = """<mujoco><option timestep="0.005" integrator="{}" gravity="0 0 0"/>
  <worldbody><site name="s0" pos="-.2 0 .1"/><site name="s1" pos="0 0 .1"/>
    <site name="wall" pos=".3 1 .4"/><body pos=".3 0 0"><freejoint/>
      <geom size=".05" mass="1"/><site name="s2" pos=".04 .01 .02"/>
      <site name="s3" pos="0 .05 .03"/></body></worldbody>
  <tendon><spatial name="t"><site site="s0"/><site site="s1"/><site site="s2"/></spatial>
    <spatial name="damped"><site site="wall"/><site site="s3"/></spatial></tendon>
  <actuator><motor tendon="t" gear="-1"/>
    <general tendon="damped" biastype="affine" biasprm="0 0 -300"/></actuator></mujoco>"""


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast"])
def test_friction_holds_a_free_body_beside_a_damper_in_the_first_step(integrator):
    model = beside_a_damper(FREE, integrator)
    data, jacobian = mujoco.MjData(model), np.zeros((3, model.nv))
    mujoco.mj_forward(model, data)
    along = data.site("s2").xpos - data.site("s1").xpos
    along /= np.linalg.norm(along)
    data.ctrl[0] = 20.0
    data.qfrc_applied[:3] = 25.0 * along + (0.0, 2.0, -1.0)
    mujoco.mj_jacSite(model, data, jacobian, None, data.site("s2").id)
    mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() > 1e-3
    assert abs(along @ jacobian @ data.qvel) < 1e-15
