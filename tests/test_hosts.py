"""In other packages' simulations each has the friction that it is given, as one of MuJoCo's own."""

import importlib
import warnings

import mujoco
import numpy as np
import pytest
from mujoco import rollout

import tendon_mj
from tests.test_snippets import FINGER

FRICTION = np.linspace(0.05, 0.4, 5)
CONTROLS = -5.0 - 3.0 * np.sin(0.1 * np.arange(60))
FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
MOTOR = '<actuator><motor tendon="flexor" ctrlrange="-9 0"/></actuator>'


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """File of a finger whose tendon a motor pulls, with friction."""
    spec = mujoco.MjSpec.from_string(FINGER.replace(' stiffness="2000"', "").format(MOTOR))
    spec = tendon_mj.add_friction(spec, "flexor", friction=0.1)
    path = tmp_path_factory.mktemp("host") / "hand.xml"
    path.write_text(spec.to_xml())
    return path


@pytest.fixture(scope="module")
def model(path):
    return mujoco.MjModel.from_xml_path(str(path))


def angles_alone(model):
    """(simulations,) last angle of the joint of each friction, simulated by itself."""
    angles = []
    for friction in FRICTION:
        data = mujoco.MjData(model)
        tendon_mj.Parameters(model, data)["flexor.friction"] = friction
        for control in CONTROLS:
            data.ctrl[:] = control
            mujoco.mj_step(model, data)
        angles.append(data.qpos[0])
    assert np.unique(angles).size == FRICTION.size
    return np.array(angles)


@pytest.fixture(scope="module")
def alone(model):
    return angles_alone(model)


@pytest.mark.parametrize("package", ["mujoco.batch", "mjbatch"])
def test_a_batch_has_a_friction_in_each_simulation(package, model, alone):
    pytest.importorskip(package)
    batch = importlib.import_module(package).Batch(model, FRICTION.size)
    live = tendon_mj.Parameters(model, batch.bind("plugin_state"))
    live["flexor.friction"] = FRICTION
    np.testing.assert_array_equal(live["flexor.friction"], FRICTION)
    control, angle = batch.bind("ctrl"), batch.bind("qpos")
    for value in CONTROLS:
        control[:] = value
        batch.step()
    np.testing.assert_array_equal(angle[:, 0], alone)


def test_a_rollout_has_a_friction_in_each_simulation(model, alone):
    data = mujoco.MjData(model)
    start = np.empty((FRICTION.size, mujoco.mj_stateSize(model, FULL)))
    mujoco.mj_getState(model, data, start[0], FULL)
    start[:] = start[0]
    tendon_mj.Parameters(model, start)["flexor.friction"] = FRICTION
    controls = np.tile(CONTROLS[:, None], (FRICTION.size, 1, 1))
    states, _ = rollout.rollout(model, [data], start, controls)
    np.testing.assert_array_equal(states[:, -1, 1], alone)  # after the time


def test_an_environment_of_gymnasium_draws_friction_at_each_reset(path, alone):
    gymnasium = pytest.importorskip("gymnasium")
    envs = pytest.importorskip("gymnasium.envs.mujoco")

    class Finger(envs.MujocoEnv):
        metadata = {"render_modes": ["human", "rgb_array", "depth_array", "rgbd_tuple"]}  # noqa: RUF012

        def __init__(self):
            observed = gymnasium.spaces.Box(-np.inf, np.inf, (1,))
            super().__init__(str(path), 1, observed)
            self.friction = iter(FRICTION)

        def reset_model(self):
            live = tendon_mj.Parameters(self.model, self.data)
            live["flexor.friction"] = next(self.friction)
            return self.data.qpos.copy()

        def step(self, action):
            self.do_simulation(action, self.frame_skip)
            return self.data.qpos.copy(), 0.0, False, False, {}

    env, angles = Finger(), []
    for _ in FRICTION:
        env.reset()
        angle = [env.step(np.array([value]))[0] for value in CONTROLS][-1]
        angles.append(angle[0])
    np.testing.assert_allclose(angles, alone, rtol=1e-12)


def test_physics_of_dm_control_keep_the_friction_of_an_episode(path, alone):
    control = pytest.importorskip("dm_control.mujoco")
    physics = control.Physics.from_xml_path(str(path))
    live = tendon_mj.Parameters(physics.model.ptr, physics.data.ptr)
    for friction, angle in zip(FRICTION, alone, strict=True):
        with physics.reset_context():
            live["flexor.friction"] = friction
        for value in CONTROLS:
            physics.set_control([value])
            physics.step()
        assert live["flexor.friction"] == friction
        np.testing.assert_allclose(physics.data.qpos[0], angle, rtol=1e-6)


def test_newton_steps_the_sheaths_that_are_put_on_its_solver(tmp_path):
    newton = pytest.importorskip("newton")
    tw = pytest.importorskip("tendon_mj.warp")
    solvers, text = newton.solvers, FINGER.replace(' stiffness="2000"', "").format(MOTOR)
    one, builder = newton.ModelBuilder(), newton.ModelBuilder()
    for each in (one, builder):
        solvers.SolverMuJoCo.register_custom_attributes(each)
    one.add_mjcf(text)
    builder.replicate(one, FRICTION.size)
    put = builder.finalize(device="cpu")
    saved = str(tmp_path / "newton.xml")
    solver = solvers.SolverMuJoCo(put, save_to_mjcf=saved)
    spec = mujoco.MjSpec.from_file(saved)
    with warnings.catch_warnings():  # of limits that Newton states, which do not act here
        warnings.simplefilter("ignore", tendon_mj.TendonWarning)
        model = tendon_mj.add_friction(spec, "flexor", friction=0.1).compile()
    tw.put_sheaths(model, solver.mjw_model, solver.mjw_data)
    tw.sheaths_of(solver.mjw_data).set("friction", FRICTION[:, None])

    def moved():
        """(worlds,) angle after sixty steps from the start."""
        before, after, control = put.state(), put.state(), put.control()
        for value in CONTROLS:
            control.mujoco.ctrl.fill_(value)
            solver.step(before, after, control, None, model.opt.timestep)
            before, after = after, before
        return solver.mjw_data.qpos.numpy()[:, 0]

    angles = moved()
    np.testing.assert_allclose(angles, angles_alone(model), atol=1e-5)
    tw.reset_data(solver.mjw_model, solver.mjw_data)
    np.testing.assert_array_equal(moved(), angles)
