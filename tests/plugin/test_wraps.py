"""Sheaths on tendons that wrap around geoms and that branch at pulleys."""

import mujoco
import numpy as np
import pytest

from tendon_mj import view_sheath
from tests.rigs import STILL, compiled, numbers, rope, sheath_view, simulated

RADIUS = 0.03
DRUM = f'size="{RADIUS} .2" euler="90 0 0"'
MAJOR = int(mujoco.__version__.split(".")[0])


def drum_model(
    turn,
    friction=0.2,
    kind="cylinder",
    *,
    drum="",
    tilt=0.0,
    actuator='<velocity tendon="t" kv="300" ctrlrange="-1 1"/>',
    **law,
):
    """A tendon that turns by ``turn`` [rad] on a drum and pulls on a mass.

    It arrives along x at the top of the drum and leaves it along the tangent; the mass slides along
    that line.
    """
    leaves = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    point = RADIUS * np.array([np.sin(turn), 0.0, np.cos(turn)])
    # beyond half a turn it must end before it meets itself
    far = 0.2 if turn < np.pi else 0.25 * RADIUS
    mass = point + far * leaves + np.array([0.0, tilt, 0.0])
    middle = 2.0 * RADIUS * np.array([np.sin(turn / 2), 0.0, np.cos(turn / 2)])
    text = rope(
        f"a -.3 0 {RADIUS}; side {numbers(middle)}",
        "b",
        "a drum@side b",
        body=f'pos="{numbers(mass)}"',
        joint=f'name="x" type="slide" axis="{numbers(leaves)}" damping="40"',
        geom='size=".005" mass=".3"',
        option=STILL,
        world=f'<body>{drum}<geom name="drum" type="{kind}" {DRUM} mass=".5"/></body>',
        actuator=actuator,
        law={"friction": friction, **law},
    )
    return compiled(text)


def arc_on_drum(model, data):
    """Length of the arc [m], from MuJoCo's own length and points."""
    p = data.wrap_xpos.reshape(-1, 3)[: data.ten_wrapnum[0]]
    return data.ten_length[0] - np.linalg.norm(p[1] - p[0]) - np.linalg.norm(p[3] - p[2])


@pytest.mark.parametrize("arc_guides", [1, 5])
@pytest.mark.parametrize("pull", [-1.0, 1.0])
@pytest.mark.parametrize("degrees", [10, 60, 120, 175, 200, 260, 320])
def test_the_capstan_law_holds_on_a_drum(degrees, pull, arc_guides):
    actuator = '<motor tendon="t" ctrlrange="-100 0"/><motor joint="x" ctrlrange="-100 100"/>'
    model = drum_model(np.radians(degrees), arc_guides=arc_guides, actuator=actuator)
    ctrl = (-20.0, 0.0) if pull < 0.0 else (-5.0, 20.0)
    data = simulated(model, 40 if degrees < 180 else 3, forward=True, ctrl=ctrl)
    goes_straight = data.ten_wrapnum[0] == 2
    wrapped = 0.0 if goes_straight else arc_on_drum(model, data) / RADIUS
    if degrees < 180:
        assert wrapped == pytest.approx(np.radians(degrees), rel=1e-6)
    else:  # MuJoCo chooses between the two ways around; from 4.0 on it may leave the drum
        assert wrapped > np.pi or (goes_straight and MAJOR >= 4)
    assert sheath_view(model, data).guides["angle"].sum() == pytest.approx(wrapped, rel=1e-9)
    tension_in, tension_out = data.sensordata
    slip = sheath_view(model, data).guides["slip"]
    sense = slip[0]
    assert (slip == sense).all()
    assert degrees > 180 or sense == -pull
    assert tension_in / tension_out == pytest.approx(np.exp(sense * 0.2 * wrapped), rel=1e-9)


@pytest.mark.parametrize("tilt", [0.0, 0.05, 0.15])
@pytest.mark.parametrize("kind", ["cylinder", "sphere"])
def test_a_helix_turns_less_than_its_projection_and_a_great_circle_by_its_angle(kind, tilt):
    """On a cylinder, φ = θ sin α with α the angle between the tendon and the axis."""
    model = drum_model(np.radians(100), kind=kind, tilt=tilt)
    data = simulated(model, 5, forward=True, ctrl=-0.5)
    p = data.wrap_xpos.reshape(-1, 3)[:4]
    direction = (p[1] - p[0]) / np.linalg.norm(p[1] - p[0])
    first, second = (x[[0, 2]] if kind == "cylinder" else x for x in p[1:3])
    turned = np.arccos(first @ second / np.linalg.norm(first) / np.linalg.norm(second))
    expected = turned * (np.sqrt(1.0 - direction[1] ** 2) if kind == "cylinder" else 1.0)
    assert sheath_view(model, data).guides["angle"].sum() == pytest.approx(expected, rel=1e-6)


def swinging(friction=0.3, arc_guides=1, **law):
    """A link whose tendon comes to lie on the joint's drum as it swings, and leaves it again."""
    text = rope(
        "a -.2 0 -.02",
        "b .15 0 -.06",
        "a drum@ b",
        joint='name="j" axis="0 1 0" damping=".3"',
        geom='type="capsule" fromto="0 0 0 .2 0 0" size=".01" mass=".1"',
        option=STILL,
        world=f'<geom name="drum" type="cylinder" {DRUM}/>',
        actuator='<motor tendon="t" ctrlrange="-50 0"/><position joint="j" kp="60" dampratio="1"/>',
        law={"friction": friction, "arc_guides": arc_guides, **law},
    )
    return compiled(text)


@pytest.mark.parametrize("arc_guides", [1, 3, 4])
def test_tension_is_continuous_when_a_wrap_appears_and_leaves_and_material_is_conserved(arc_guides):
    """What a segment loses its neighbours gain, apart from what comes in at the input."""
    model = swinging(0.3, arc_guides, axial_stiffness=1e6)
    data = simulated(model, 1)
    wrapped, ratios, angles = [], [], []
    for step in range(4000):
        data.ctrl[:] = -20.0, 1.2 * np.sin(2.0 * np.pi * step / 2000.0)
        before = sheath_view(model, data).segments["stored"].copy()
        mujoco.mj_step(model, data)
        _, segments, guides, _ = sheath_view(model, data)
        passed = np.append(guides["trial_flow"] + guides["trial_shift"], 0.0)
        material = np.diff(passed) + segments["trial_yield"][1:]
        assert (segments["stored"] - before)[1:] == pytest.approx(material, abs=1e-15)
        wrapped.append(data.ten_wrapnum[0] > 2)
        ratios.append(np.log(data.sensordata[1] / data.sensordata[0]))
        angles.append(guides["angle"].sum())
    assert 2 <= np.count_nonzero(np.diff(wrapped)) <= 8
    jumps, turned = np.abs(np.diff(ratios[10:])), np.abs(np.diff(angles[10:]))
    changes = np.flatnonzero(np.diff(wrapped[10:]))
    near = np.concatenate([np.arange(k - 2, k + 4) for k in changes])
    assert (jumps[near] <= 0.3 * turned[near] + 1e-6).all()
    assert np.abs(ratios).max() > 0.1, "it rubs in between"


def test_a_drum_that_turns_under_a_tendon_that_rests_rubs():
    """Tendon rubs on the surface: with the tendon held, turning the drum slides it."""
    drum = '<joint name="spin" axis="0 1 0"/>'
    actuator = '<motor tendon="t" ctrlrange="-50 0"/><velocity joint="spin" kv="0.05"/>'
    actuator += '<position joint="x" kp="1e4" kv="300"/>'
    for sense in (1.0, -1.0):
        model = drum_model(np.radians(90), drum=drum, actuator=actuator)
        data = simulated(model, 200, forward=True, ctrl=[-10.0, sense * 3.0, 0.0])
        tension_in, tension_out = data.sensordata
        # the drum takes the tendon along, towards the output where it turns by its axis
        turn = 0.2 * sheath_view(model, data).guides["angle"].sum()
        assert np.log(tension_in / tension_out) == pytest.approx(sense * turn, rel=1e-6)
        drag = data.qfrc_passive[model.joint("spin").dofadr[0]]
        assert drag == pytest.approx(-RADIUS * (tension_in - tension_out), rel=1e-6)


@pytest.mark.parametrize("extra_bend", [0.0, 1.0, 6.0])
@pytest.mark.parametrize("arc_guides", [1, 4])
def test_friction_work_is_what_the_joint_does_not_get_where_a_wrap_comes_and_goes(
    arc_guides, extra_bend
):
    model = swinging(0.3, arc_guides, extra_bend=extra_bend, inner_guides=2)
    model.opt.timestep = 2e-4
    data = simulated(model)
    lost, put_in, wrapped = 0.0, 0.0, []
    for step in range(10000):
        data.ctrl[:] = -20.0, 1.2 * np.sin(2.0 * np.pi * step / 10000.0)
        angle, length = data.qpos[0], data.ten_length[0]
        damping = 0.3 * data.qvel[0]
        mujoco.mj_step(model, data)
        servo = data.actuator_force[1]
        pull = data.qfrc_actuator[0] - servo + data.qfrc_passive[0] + damping
        mujoco.mj_kinematics(model, data)
        mujoco.mj_tendon(model, data)
        wound_in = 20.0 * (length - data.ten_length[0])
        lost += wound_in - pull * (data.qpos[0] - angle)
        put_in += abs(wound_in)
        wrapped.append(data.ten_wrapnum[0] > 2)
    assert np.count_nonzero(np.diff(wrapped)) >= 2
    work = sheath_view(model, data).guides["friction_work"].sum()
    assert work > 0.02
    assert work == pytest.approx(lost, abs=0.002 * put_in)


def test_partial_slip_on_a_drum_converges_with_its_guides():
    """With the mass held, pulling lets a front of slip run in; more guides resolve it."""

    def arrived(guides):
        actuator = '<motor tendon="t" ctrlrange="-100 0"/><position joint="x" kp="1e6" kv="3e3"/>'
        law = {"arc_guides": guides, "axial_stiffness": 5e3}
        model = drum_model(np.radians(170), 0.3, actuator=actuator, **law)
        data = mujoco.MjData(model)
        history = []
        for step in range(300):
            data.ctrl[0] = -20.0 - 15.0 * np.sin(step / 50.0)
            mujoco.mj_step(model, data)
            history.append(data.sensordata[1])
        return np.array(history)

    fine = arrived(64)
    errors = [np.abs(arrived(n) - fine).max() for n in (1, 4, 16)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.05 * np.ptp(fine)


MOVED = """<body pos=".3 .05 0"><joint name="one" type="slide" axis="1 0 0" damping="20"/>
  <geom size=".01" mass=".3"/><site name="e"/></body>"""


def pulleys(start="k", second="/2 {} p e"):
    """A tendon with three branches; two begin at a site, where the first one may end."""
    text = rope(
        "a -.2 0 0; b 0 0 .05; k .1 0 0; p .2 .05 .05; q .2 -.05 .05",
        "f",
        f"a b k {second.format(start)} /4 {start} q f",
        body='pos=".3 -.05 0"',
        joint='name="two" type="slide" axis="1 0 0" damping="20"',
        geom='size=".01" mass=".3"',
        option=STILL,
        world=MOVED,
        actuator='<motor tendon="t" ctrlrange="-50 0"/>',
        law={"friction": 0.3},
    )
    return compiled(text)


@pytest.mark.parametrize("start", ["k", "b"])
def test_each_branch_has_a_friction_state_of_its_own(start):
    model = pulleys(start)
    data = simulated(model, 50, forward=True, ctrl=-12.0)
    state = sheath_view(model, data)
    tension = view_sheath(model, data, "t").tension
    angles, divided = state.guides["angle"], state.guides["is_pulley"]
    assert list(divided) == [0.0, 1.0, 0.0, 1.0, 0.0]
    # the first branch slides as the others draw their tendon through it; else it holds
    first = tension[1] if start == "k" else 12.0
    if start == "k":
        assert tension[1] == pytest.approx(12.0 * np.exp(-0.3 * angles[0]))
    assert tension[0] == pytest.approx(12.0)
    assert tension[2] == pytest.approx(first / 2.0)
    assert tension[4] == pytest.approx(first / 4.0)
    assert tension[2] / tension[3] == pytest.approx(np.exp(0.3 * angles[2]), rel=1e-9)
    assert tension[4] / tension[5] == pytest.approx(np.exp(0.3 * angles[4]), rel=1e-9)
    own = data.qfrc_passive - (-20.0) * data.qvel + data.qfrc_actuator
    for dof, (site, end, segment) in enumerate([("p", "e", 3), ("q", "f", 5)]):
        to = data.site(site).xpos - data.site(end).xpos
        force = tension[segment] * to[0] / np.linalg.norm(to)  # on a joint that of its branch
        assert own[dof] == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("divisor", [None, 1, 2, 3])
@pytest.mark.parametrize("outwards", [1.0, -1.0])
def test_a_branch_draws_its_tendon_through_the_one_that_feeds_it(divisor, outwards):
    """Two quarter turns before a pulley rub as they do without it, and nothing makes energy."""
    text = rope(
        "a 0 0 .2; b; c .1 0 0; end .1 0 .1",
        "e",
        "a b c end e" if divisor is None else f"a b c end /{divisor} end e",
        body='pos=".1 0 .3"',
        joint='name="z" type="slide" axis="0 0 1"',
        geom='size=".01" mass="5"',
        option='gravity="0 0 0"',
        actuator='<motor tendon="t"/><position joint="z" kp="5000" kv="200"/>',
        law={"friction": 0.3},
    )
    model = compiled(text)
    data = simulated(model, 1, ctrl=[-10.0, 0.0])
    work = before = 0.0
    for k in range(1500):
        data.ctrl[1] = outwards * 0.05 * min(1.0, k / 1000)
        mujoco.mj_step(model, data)
        if k == 500:
            before = sheath_view(model, data).guides["friction_work"].sum()
        if 500 < k <= 900:
            power = data.actuator_force[0] * data.ten_velocity[0]
            work += (power + data.actuator_force[1] * data.qvel[0]) * model.opt.timestep
        if k == 900:
            tension_in, tension_out = data.sensordata
            ratio = tension_out * (divisor or 1) / tension_in
            rubbed = sheath_view(model, data).guides["friction_work"].sum() - before
    assert ratio == pytest.approx(np.exp(outwards * 0.3 * np.pi), rel=1e-9)
    assert rubbed == pytest.approx(work, rel=0.02)


def bound_again(before, after):
    """A step of ``after`` from a state of ``before``, and from none; their sheaths' guides."""
    old = simulated(before, 5, ctrl=-12.0)
    return [
        sheath_view(after, simulated(after, 1, ctrl=-12.0, plugin_state=state)).guides
        for state in (old.plugin_state, np.zeros(after.npluginstate))
    ]


@pytest.mark.parametrize("mark", ["is_pulley", "fed_by"])
@pytest.mark.parametrize(
    ("before", "after"),
    [({"start": "b"}, {}), ({}, {"second": "p /2 {} e"})],
    ids=["another start", "another place"],
)
def test_a_state_of_other_branches_is_bound_to_these(mark, before, after):
    kept, fresh = bound_again(pulleys(**before), pulleys(**after))
    assert np.array_equal(kept[mark], fresh[mark])
