"""Bend that the drawn path does not show: tendons whose guides are at their first site."""

import math

import mujoco
import numpy as np
import pytest

from tendon_mj import TendonWarning, add_friction, view_sheath
from tests.refusals import silent
from tests.rigs import STILL, rope, simulated

MU, BEND = 0.2, 2.0
RATIO = math.exp(MU * BEND)
PULLED = {
    "motor": '<motor tendon="t"/>',
    "muscle": '<muscle tendon="t" force="60" lengthrange=".1 .5"/>',
}
PATHS = {"two sites": "a b", "a site between": "a k b", "a drum": "a drum@ b"}
PULLEY = "a k /2 k b"


def rig(actuators=PULLED["motor"], path=PATHS["two sites"], tendon=""):
    """A mass on a slide at the end of a tendon, pulled by a motor of its own besides."""
    text = rope(
        "a; k .1 0 .05",
        "b",
        path,
        tendon=tendon,
        body='pos=".3 0 0"',
        joint='name="x" type="slide" axis="1 0 0" damping="40"',
        geom='size=".01" mass=".3"',
        option=STILL,
        world='<geom name="drum" type="cylinder" size=".02" fromto=".15 -.1 .01 .15 .1 .01"/>',
        actuator=f'{actuators}<motor name="load" joint="x"/>',
    )
    return mujoco.MjSpec.from_string(text)


def sliding(spec, pull, load, steps=40):
    """View of the sheath as it slides steadily."""
    model = spec.compile()
    data = simulated(model, steps, forward=True, ctrl=(pull, load))
    return view_sheath(model, data, "t"), data


@pytest.mark.parametrize("inner", [None, 1, 2, 16])
@pytest.mark.parametrize(("pull", "load", "sense"), [(-20.0, 0.0, 1.0), (-5.0, 20.0, -1.0)])
def test_a_motor_over_two_sites_loses_what_the_bend_says(pull, load, sense, inner):
    spec = add_friction(rig(), "t", friction=MU, extra_bend=BEND, inner_guides=inner)
    view, data = sliding(spec, pull, load)
    assert view.input_tension == -pull
    assert view.input_tension / view.output_tension == pytest.approx(RATIO**sense, rel=1e-9)
    assert (view.slip == sense).all()
    assert view.slip.size == (inner or 1)
    felt = data.qfrc_actuator[0] - load + data.qfrc_passive[0] + 40.0 * data.qvel[0]
    assert felt == pytest.approx(-view.output_tension, rel=1e-9)


@pytest.mark.parametrize("inner", [None, 0, 3])
@pytest.mark.parametrize("path", ["a site between", "a drum"])
@pytest.mark.parametrize(("pull", "load", "sense"), [(-20.0, 0.0, 1.0), (-5.0, 20.0, -1.0)])
def test_drawn_guides_share_it_with_those_at_the_first_site(pull, load, sense, path, inner):
    spec = rig(path=PATHS[path])
    add_friction(spec, "t", friction=MU, extra_bend=BEND, inner_guides=inner)
    if inner == 0 and path == "a drum":
        with pytest.raises(ValueError, match=r"extra_bend = 2\.0 .*inner_guides"):
            spec.compile()
        return
    by_default = inner is None and path == "a drum"  # which the tendon may leave
    assert ("inner_guides" in spec.plugin("t_sheath").config) == bool(inner or by_default)
    view, _ = sliding(spec, pull, load)
    bend = BEND + view.bend_angle.sum()
    assert bend > BEND + 0.05
    ratio = math.exp(sense * MU * bend)
    assert view.input_tension / view.output_tension == pytest.approx(ratio, rel=1e-9)


def test_a_muscle_over_two_sites_loses_it_too():
    view, _ = sliding(
        add_friction(rig(PULLED["muscle"]), "t", friction=MU, extra_bend=BEND), 1.0, 0.0
    )
    assert view.input_tension > 1.0
    assert view.input_tension / view.output_tension == pytest.approx(RATIO, rel=1e-9)


@pytest.mark.parametrize(("sense", "way"), [(1.0, 1e-5), (-1.0, -1e-5)])
@pytest.mark.parametrize("inner", [None, 4])
def test_a_reel_over_two_sites_feels_it(sense, way, inner):
    spec = rig("", tendon='stiffness="40" springlength="0 .2"')
    spec.joint("x").stiffness[0], spec.joint("x").springref = 500.0, 0.01
    add_friction(spec, "t", friction=MU, extra_bend=BEND, inner_guides=inner, reel="reel")
    model = spec.compile()
    data = mujoco.MjData(model)
    for k in range(300):
        data.actuator("reel").ctrl[0] = way * k
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    view = view_sheath(model, data, "t")
    assert view.output_tension > 1.0
    assert view.input_tension / view.output_tension == pytest.approx(RATIO**sense, rel=1e-9)


def test_a_spring_over_two_sites_stays_and_its_pull_is_the_input_tension():
    """The spring moved into the sheath would lie behind the friction, which did nothing then."""
    spring = 'stiffness="40" springlength="0 .2"'
    spec = add_friction(rig("", tendon=spring), "t", friction=MU, extra_bend=BEND)
    model = spec.compile()
    assert model.tendon_stiffness[0] == 40.0
    data = mujoco.MjData(model)
    ratios = []
    for load in (0.0, 12.0):
        data.ctrl[:] = load
        mujoco.mj_step(model, data, 40)
        mujoco.mj_forward(model, data)
        view = view_sheath(model, data, "t")
        assert view.input_tension == pytest.approx(40.0 * (data.ten_length[0] - 0.2), rel=1e-9)
        ratios.append(view.input_tension / view.output_tension)
    assert ratios == pytest.approx([RATIO, 1.0 / RATIO], rel=1e-9)


def test_tension_independent_friction_alone_is_enough_too():
    view, _ = sliding(add_friction(rig(), "t", friction=0.0, constant_friction=3.0), -20.0, 0.0)
    assert view.input_tension - view.output_tension == pytest.approx(3.0, rel=1e-9)


def test_a_branch_that_begins_where_the_first_one_ends_takes_over_what_arrives_there():
    spec = rig(path=PULLEY)
    add_friction(spec, "t", friction=MU, extra_bend=BEND)
    assert spec.plugin("t_sheath").config["guides"] == "2"
    view, _ = sliding(spec, -20.0, 0.0)
    # the first branch is between fixed sites: its guide holds, with what it was laid with
    assert view.tension[2] == pytest.approx(view.tension[1] / 2.0, rel=1e-9)


IDLE = [
    (PATHS["two sites"], {}),
    (PATHS["two sites"], {"inner_guides": 2}),
    (PATHS["two sites"], {"extra_bend": -1.0}),
    (PATHS["two sites"], {"extra_bend": 1.0, "inner_guides": 0}),
    (PULLEY, {}),
]


@pytest.mark.parametrize(("path", "given"), IDLE)
def test_a_driven_tendon_on_which_nothing_rubs_is_warned_of(path, given):
    with pytest.warns(TendonWarning, match=r"no effect on 't'.*give extra_bend"):
        add_friction(rig(path=path), "t", friction=MU, **given).compile()


@pytest.mark.parametrize("more", [{}, {"output_joint": "x", "output_radius": 1.0}])
def test_a_tendon_held_at_its_only_guide_is_said_to_be_idle(more):
    given = {"axial_stiffness": 1e4, "pretension": 5.0, "extra_bend": BEND}
    for end in ("first", "last"):
        with pytest.warns(TendonWarning, match=rf"no effect on 't'.*its {end} site.*reel"):
            add_friction(rig(""), "t", friction=MU, input_end=end, **given, **more).compile()
    with silent():
        add_friction(rig(""), "t", friction=MU, **given, reel="reel").compile()


def test_holding_and_reversing_the_ratio_stays_within_what_the_bend_allows():
    model = add_friction(rig(), "t", friction=MU, extra_bend=BEND, inner_guides=8).compile()
    data = mujoco.MjData(model)
    ratios = []
    for k in range(2000):
        data.ctrl[:] = -20.0 - 10.0 * np.sin(k / 100.0), 18.0 + 5.0 * np.sin(k / 170.0)
        mujoco.mj_step(model, data)
        view = view_sheath(model, data, "t")
        ratios.append(math.log(view.input_tension / view.output_tension))
    assert min(ratios) == pytest.approx(-MU * BEND, rel=1e-9)
    assert max(ratios) == pytest.approx(MU * BEND, rel=1e-9)
    assert view.unsolved == 0


def limb(path):
    """A limb whose insertion is on a body of its own, with a drum there."""
    link = """<body><site name="c" pos=".05 0 .01"/>
      <geom name="drum" pos=".06 0 0" size=".005"/></body><site name="d" pos=".09 0 .03"/>"""
    return mujoco.MjSpec.from_string(
        rope("a; w .02 0 .05", "b 0 0 .03", path, body='pos=".1 0 0"', link=link)
    )


def moved(path, friction, **more):
    model = add_friction(limb(path), "t", friction=friction, **more).compile()
    return simulated(model, 20, ctrl=-3.0).qpos


@pytest.mark.parametrize(
    ("path", "input_end"),
    [("a b c d", "first"), ("b c d", "first"), ("d c b a", "last"), ("a b drum@ d", "first")],
)
def test_guides_that_pull_on_the_insertion_s_body_alone_are_said_to_do_nothing(path, input_end):
    with pytest.warns(TendonWarning, match="body at which it ends.*extra_bend"):
        poses = [moved(path, friction, input_end=input_end) for friction in (0.0, 2.0)]
    np.testing.assert_allclose(*poses, rtol=1e-12)


@pytest.mark.parametrize(
    ("path", "more"),
    [("a w b d", {}), ("a w b", {}), ("a b c d", {"input_end": "last"}),
     ("a b c d", {"extra_bend": 1.0, "inner_guides": 1})],
)  # fmt: skip
def test_others_are_not(path, more):
    with silent(TendonWarning):
        free, rubbed = (moved(path, friction, **more) for friction in (0.0, 2.0))
    assert abs(free - rubbed).max() > 0.01 * abs(free).max()
