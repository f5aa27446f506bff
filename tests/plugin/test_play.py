"""Laws of drums and pulleys with play, which have no mass and are shared by cables."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import tendon_mj
from tendon_mj import add_friction, view_sheath
from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import sheath_arrays, sheaths, unsolved_evaluations

ARM = """<mujoco><option timestep="0.001" integrator="implicitfast" gravity="0 {g} 0"/>
<worldbody><site name="a"/><site name="b" pos=".1 0 0"/>
<body pos="0 1 0"><inertial pos="0 0 0" mass="1" diaginertia=".002 .002 .002"/>
<joint name="motor" damping=".02"/></body>
<body pos=".2 0 0"><inertial pos="0 -.2 0" mass=".5" diaginertia=".01 .01 .01"/>
<joint name="arm" damping="{damping}"/></body></worldbody>
<tendon><spatial name="one"><site site="a"/><site site="b"/></spatial>
<spatial name="two"><site site="a"/><site site="b"/></spatial></tendon>
<actuator><position name="servo" joint="motor" kp="40" kv="1"/></actuator></mujoco>"""
RADIUS, DRUM = 0.03, 0.02
CABLES = ("one", "two")


def arm(g=-9.81, damping=0.5, order=(0, 1), **law):
    """An arm that two cables turn, which pull against each other on a motor's drum."""
    spec = mujoco.MjSpec.from_string(ARM.format(g=g, damping=damping))
    given = {"friction": 0.2, "axial_stiffness": 2e3, "pretension": 30.0, "extra_bend": 1.0} | law
    for k in order:
        side = (1.0, -1.0)[k]
        ends = {"reel_joint": "motor", "reel_radius": side * DRUM}
        ends |= {"output_joint": "arm", "output_radius": -side * RADIUS}
        add_friction(spec, CABLES[k], inner_guides=3, sensors=("input_tension",), **given, **ends)
    model = spec.compile()
    return model, mujoco.MjData(model)


def run(model, data, seconds, goal=lambda t: 0.0, seen=lambda: None):
    """Step, and return what was seen after each."""
    rows = []
    for _ in range(round(seconds / model.opt.timestep)):
        data.ctrl[0] = goal(data.time)
        mujoco.mj_step(model, data)
        rows.append(seen())
    return np.array(rows, float)


def state_of(model, data, sheath="one_sheath"):
    return sheath_arrays(model, data.plugin_state, sheath, sheaths(model)[sheath].state).state


def pulley_of(model, data):
    """Angle of the pulley in the last step [rad]."""
    return state_of(model, data)["pulley"]


def ends(model, data):
    """Tensions of both cables at the output [N]."""
    return [view_sheath(model, data, cable).tension[-1] for cable in CABLES]


def test_between_its_flanks_a_pulley_is_where_its_cables_balance_and_the_joint_is_free():
    model, data = arm(g=0.0, damping=0.0, output_play=0.4)
    data.qvel[1] = 0.5
    seen = run(
        model, data, 0.3, seen=lambda: (*ends(model, data), data.qvel[1], pulley_of(model, data))
    )
    assert np.ptp(seen[:, :2], axis=1).max() < 1e-10 * 30.0
    assert seen[:, 2] == pytest.approx(0.5, rel=1e-10)
    assert seen[:, 3] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_pulley_stays_between_its_flanks_and_only_on_one_it_turns_the_joint(friction):
    width = 0.05
    model, data = arm(output_play=width, friction=friction)

    def seen():
        offset = pulley_of(model, data) - at[0]
        at[0] = data.qpos[1]  # which the next step evaluates
        return offset, *ends(model, data)

    at = [0.0]
    goal = lambda t: 0.6 * np.sin(5.0 * t)  # noqa: E731
    offset, one, two = run(model, data, 3.0, goal, seen).T
    assert abs(offset).max() < 0.5 * width * (1.0 + 1e-9)
    net = abs(one - two) / (one + two)
    free = abs(offset) < 0.5 * width * (1.0 - 1e-9)
    assert 0.05 < free.mean() < 0.95
    assert net[free].max() < 1e-10
    pressed = np.sign(one - two) == np.sign(offset)
    assert pressed[~free & (net > 1e-9)].all(), "a flank pushes and does not pull"


def test_a_play_may_be_wider_than_a_stretch_of_the_cable_is_long():
    """Its flanks are then where there is not that much tendon to wind, and nobody comes there."""
    model, data = arm(g=0.0, damping=0.0, output_play=8.0)
    data.qvel[1] = 0.5
    seen = run(model, data, 0.5, lambda t: 0.5 * np.sin(9 * t), lambda: data.qvel[1])
    assert seen == pytest.approx(0.5, rel=1e-9)
    assert unsolved_evaluations(model, data) == {"one_sheath": 0, "two_sheath": 0}


def test_a_play_of_nothing_is_none():
    turned = []
    for width in (0.0, 1e-9):
        model, data = arm(output_play=width, reel_play=width)
        turned.append(run(model, data, 1.0, lambda t: np.sin(4 * t), lambda: data.qpos.copy()))  # noqa: B023
    assert turned[1] == pytest.approx(turned[0], abs=1e-7)


@pytest.mark.parametrize("effect", [{}, {"viscous_friction": 200.0}, {"tendon_mass": 0.01}])
def test_right_before_guides_too_a_motor_is_free_within_the_play_of_its_drum(effect):
    """The tendon between has no length there, and no angle of the drum may balance its cables."""
    model, data = arm(output_play=0.04, reel_play=0.03, **effect)
    free = []
    for _ in range(1000):
        turned, rate = data.qpos[0], data.qvel[0]
        data.ctrl[0] = 0.8 * np.sin(6.0 * data.time)
        mujoco.mj_step(model, data)
        if abs(state_of(model, data)["drum"] - turned) < 0.5 * 0.03 * (1.0 - 1e-9):
            free.append(data.qfrc_passive[0] + 0.02 * rate)
    assert len(free) > 20
    assert np.abs(free).max() < 1e-12


@pytest.mark.parametrize("play", ["output_play", "reel_play"])
def test_a_load_that_changes_sides_goes_through_the_play(play):
    """Slowly, the arm lags behind its motor by as much more as the play is wide."""
    width, shift = 0.06, {}
    for given in (0.0, width):
        at = []
        for sense in (1.0, -1.0):
            model, data = arm(g=0.0, friction=0.0, **{play: given})
            data.qfrc_applied[1] = sense * 0.3
            run(model, data, 4.0)
            motor = data.qpos[0] * (DRUM / RADIUS)
            at.append(data.qpos[1] - motor)
        shift[given] = at[0] - at[1]
    ratio = 1.0 if play == "output_play" else DRUM / RADIUS
    assert shift[width] - shift[0.0] == pytest.approx(width * ratio, rel=1e-3)


def test_a_motor_turns_freely_in_the_play_of_its_drum():
    model, data = arm(g=0.0, reel_play=0.2)
    torque = run(model, data, 1.0, lambda t: 0.08 * min(1.0, t), lambda: data.qfrc_passive[0])
    friction = model.dof_damping[0, 0] if model.dof_damping.ndim > 1 else model.dof_damping[0]
    assert abs(torque).max() < 1.01 * friction * abs(0.2)
    assert data.qpos[1] == pytest.approx(0.0, abs=1e-9)


def test_the_load_of_the_reference_pose_says_on_which_flank_the_joint_begins():
    for rest, begin in ((1.0, 0.0), (-1.0, 1.0), (0.0, 0.5)):
        model, data = arm(g=0.0, friction=0.0, output_play=0.1)
        for cable in CABLES:
            view_sheath(model, data, cable).output_rest = rest
        data.qfrc_applied[1] = 0.5
        still, _ = arm(g=0.0, friction=0.0)
        other = mujoco.MjData(still)
        other.qfrc_applied[1] = 0.5
        run(model, data, 3.0)
        run(still, other, 3.0)
        assert data.qpos[1] - other.qpos[1] == pytest.approx(0.1 * begin, abs=1e-4)


@pytest.mark.parametrize(
    ("plays", "near"),
    [({"output_play": 0.04}, 1e-12), ({"output_play": 0.04, "reel_play": 0.03}, 1e-5)],
)
def test_the_order_of_the_cables_is_of_no_effect(plays, near):
    found = []
    for order in ((0, 1), (1, 0)):
        model, data = arm(order=order, **plays)
        run(model, data, 1.0, lambda t: np.sin(6 * t))
        found.append(data.qpos.copy())
    assert found[0] == pytest.approx(found[1], abs=near)


def test_a_pulley_rests_as_its_cables_say_in_the_mean():
    found = []
    for order in ((0, 1), (1, 0)):
        model, data = arm(g=0.0, friction=0.0, order=order, output_play=0.1)
        view_sheath(model, data, "one").output_rest = 1.0
        data.qfrc_applied[1] = 0.5
        run(model, data, 3.0)
        found.append(data.qpos[1].copy())
    assert found[0] == pytest.approx(found[1], abs=1e-9)


def test_each_cable_of_a_pulley_that_is_not_solved_is_warned_of():
    spec = mujoco.MjSpec.from_string(ARM.format(g=0, damping=0.5))
    for cable, side in (("one", 1.0), ("two", -1.0)):
        ends = {"output_joint": "arm", "output_radius": side * RADIUS, "output_play": 0.1}
        law = {"friction": 0.2, "axial_stiffness": 2e3, "pretension": 30.0, "extra_bend": 1.0}
        add_friction(spec, cable, reel=f"{cable}_reel", **law, **ends)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.actuator("one_reel").ctrl = 10.0
    mujoco.mj_forward(model, data)
    for sheath, unsolved in unsolved_evaluations(model, data).items():
        assert state_of(model, data, sheath)["warned"] == unsolved
    assert unsolved_evaluations(model, data)["one_sheath"] == 1


def test_a_copy_and_a_state_go_on_to_the_bit():
    model, data = arm(output_play=0.04, reel_play=0.03)
    goal = lambda t: np.sin(6 * t)  # noqa: E731
    run(model, data, 0.4, goal)
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    copied, restored = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_copyData(copied, model, data)
    mujoco.mj_setState(model, restored, state, kind)
    for other in (data, copied, restored):
        run(model, other, 0.6, goal)
    assert np.array_equal(data.qpos, copied.qpos)
    assert np.array_equal(data.qpos, restored.qpos)


def test_play_makes_no_energy():
    """An arm without friction that swings from flank to flank rises as high every time."""
    lost = []
    for step in (1e-3, 2.5e-4):
        model, data = arm(damping=0.0, friction=0.0, output_play=0.3)
        model.opt.timestep, model.dof_damping[:] = step, 0.0
        model.dof_armature[0] = 1e9  # a motor that is held
        mujoco.mj_setConst(model, mujoco.MjData(model))
        data.qpos[1] = 0.6
        angle = run(model, data, 10.0, seen=lambda d=data: d.qpos[1].copy())
        turns = np.flatnonzero(np.diff(np.sign(np.diff(angle)))) + 1
        heights = abs(angle[turns])
        assert heights.size > 10
        lost.append(np.ptp(heights) / 0.6)
    assert lost[1] < 0.5 * lost[0] < 0.05


def test_runge_kutta_sees_the_same_play_in_coarse_steps_as_in_fine_ones():
    kept = {}
    for step in (1e-3, 5e-4):
        model, data = arm(friction=0.1, output_play=0.05)
        model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, step
        run(model, data, 1.0, lambda t: np.sin(4 * t))
        kept[step] = data.qpos.copy()
    assert kept[1e-3] == pytest.approx(kept[5e-4], abs=2e-3)


def test_play_is_refused_without_a_joint_and_below_0():
    spec = mujoco.MjSpec.from_string(ARM.format(g=0, damping=0))
    for given, said in (
        ({"output_play": 0.1}, "output_play and output_joint go together"),
        ({"reel_joint": "motor", "reel_radius": 0.1, "reel_play": -0.1}, "reel_play = -0.1"),
    ):
        with pytest.raises(InvalidValueError, match=said):
            add_friction(spec, "one", friction=0.1, axial_stiffness=1e3, **given)
    model, data = arm(g=0.0)
    with pytest.raises(InvalidValueError, match="output_play"):
        tendon_mj.Parameters(model, data)["one.output_play"] = -1.0
