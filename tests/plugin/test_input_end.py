"""A sheath whose input end is the last site: that of the same tendon drawn the other way round."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Spool, add_friction, remove_friction, view_sheath
from tendon_mj.errors import InvalidValueError, TendonWarning
from tendon_mj.lab.step_cost import smooth_controls
from tendon_mj.plugin import sheaths
from tests.refusals import refusing
from tests.rigs import (
    MUJOCO,
    compiled,
    config,
    hands_on_plugin_states,
    rope,
    sheath,
    sheath_view,
    shown,
    simulated,
    spatial,
    two_links,
)

MOTOR = '<motor name="pull" tendon="t" ctrlrange="-20 0"/>'
OTHERS = """<motor joint="one" ctrlrange="-1 1"/><motor joint="two" ctrlrange="-.5 .5"/>
  <motor joint="reel" ctrlrange="-.1 .1"/>"""
PATHS = {
    "sites": "a b c d e",
    "on one spot": "a b b2 c d e",
    "cylinder": "a wheel@s c d",
    "both": "a b wheel@s c ball@t d e",
    # no guide on the link that it pulls, so that all of it slides
    "short": "a b c d",
    "both, short": "a b wheel@s c ball@t d",
}
SENSORS = ("input_tension", "output_tension", "tension", "bend_angle", "slip", "friction_work")
SUMS = 1e-9  # relative; MuJoCo's own sums come in another order, and friction takes that further


def arm(path, input_end, pull=MOTOR, tendon="", integrator="Euler", **law):
    """The arm with friction on its tendon, drawn from its input end or up to it."""
    words = PATHS[path].split()
    drawn = " ".join(words if input_end == "first" else words[::-1])
    option = f'timestep="0.001" integrator="{integrator}"'
    text = two_links(drawn, tendon=tendon, actuator=pull + OTHERS, option=option)
    law = {"friction": 0.3, "sensors": SENSORS} | law
    return add_friction(mujoco.MjSpec.from_string(text), "t", input_end=input_end, **law)


def motion(model, steps=1000):
    """Positions, velocities and sensors in every step, and the data at the end."""
    data, rows = mujoco.MjData(model), []
    for row in smooth_controls(model, steps):
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
        rows.append((data.qpos.copy(), data.qvel.copy(), data.sensordata.copy()))
    return [np.array(column) for column in zip(*rows, strict=True)], data


def check_alike(models, steps=1000, rel=1e-12):
    (one, first), (other, last) = (motion(model, steps) for model in models)
    for expected, actual in zip(one, other, strict=True):
        np.testing.assert_allclose(actual, expected, rtol=0.0, atol=rel * np.abs(expected).max())
    views = [view_sheath(m, d, "t") for m, d in zip(models, (first, last), strict=True)]
    np.testing.assert_allclose(views[1].positions, views[0].positions, rtol=0.0, atol=1e-12)
    assert not any(view.unsolved for view in views)
    return one


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize("arc_guides", [1, 3])
@pytest.mark.parametrize("path", PATHS)
def test_it_moves_as_the_tendon_drawn_the_other_way_round(path, arc_guides, integrator):
    if (path, arc_guides) == ("cylinder", 3) and integrator != "RK4" and MUJOCO < (3, 16):
        pytest.skip(
            "before MuJoCo 3.16 its rounding depends on the order, and friction amplifies it"
        )
    law = {"arc_guides": arc_guides, "integrator": integrator}
    models = [arm(path, end, **law).compile() for end in ("first", "last")]
    # stages of RK4 add up how MuJoCo rounds tangent points, which on 4.0 depends on the order
    rel = SUMS if integrator == "RK4" else 1e-12
    positions, _, sensors = check_alike(models, rel=rel)
    assert np.ptp(positions, axis=0)[:2].min() > 0.1
    assert np.abs(np.diff(sensors[:, :2])).max() > 1.0, "it rubs"


EFFECTS = {
    "a muscle": {"pull": '<muscle tendon="t" force="60" lengthrange=".2 .6"/>'},
    "a spring": {"pull": "", "tendon": 'stiffness="60" springlength="0 .25" damping=".4"',
                 "spring": "input"},
    # slip left out: where it holds, MuJoCo's part and the sheath's cancel but for rounding
    "an elastic tendon": {"pull": "", "tendon": 'stiffness="60" springlength="0 .25" damping=".4"',
                          "sensors": ("tension", "bend_angle", "friction_work")},
    "static friction": {"static_friction": 0.5},
    "direction": {"direction_asymmetry": 0.4},
    "travel": {"friction_gradient": 5.0},
    "stiffening and creep": {"axial_stiffness": 1e3, "stiffening": 5.0, "creep": 0.1,
                             "creep_time": 0.2},
    "bend at the input end": {"extra_bend": 0.8, "inner_guides": 2},
}  # fmt: skip


WOUND = {"pull": "", "axial_stiffness": 2e3, "pretension": 5.0}
WINDERS = {
    "reel": {"reel": "reel_actuator"},
    "joint": {"reel_joint": "reel", "reel_radius": 0.02},
    "both ends": {"reel_joint": "reel", "reel_radius": 0.02, "output_joint": "drum",
                  "output_radius": 0.5},
    "output": {"output_joint": "drum", "output_radius": 0.5},
    "none": {},
}  # fmt: skip
CASES = [*(("both", law) for law in EFFECTS.values())]
CASES += [(path, WOUND | winder) for path in PATHS for winder in WINDERS.values()]


@pytest.mark.parametrize(("path", "law"), CASES, ids=str)
def test_so_it_does_with_any_effect_and_any_drive(path, law):
    specs = [arm(path, end, **law) for end in ("first", "last")]
    if "reel" in law:
        for spec in specs:
            spec.actuators[-1].ctrlrange = [-0.005, 0.02]  # MuJoCo 3.11 finds none by a new name
    check_alike([spec.compile() for spec in specs], rel=SUMS)


@pytest.mark.parametrize("path", ["sites", "cylinder"])
def test_a_spool_is_at_the_input_end(path):
    specs = [
        arm(path, end, axial_stiffness=2e4, spool=Spool(radius=0.01)) for end in ("first", "last")
    ]
    models = [spec.compile() for spec in specs]
    check_alike(models, rel=SUMS)
    assert models[1].body("t_spool").parentid[0] == models[1].site("a").bodyid[0]
    again = remove_friction(specs[1], "t").compile()
    assert again.actuator("pull").trnid[0] == again.tendon("t").id


@pytest.mark.parametrize("path", ["short", "cylinder", "both, short"])
def test_sliding_steadily_the_capstan_ratio_is_that_of_the_whole_bend(path):
    """And sensors and views begin at the input end."""
    pull = '<velocity tendon="t" kv="60" ctrlrange="-1 0"/>'
    model = arm(path, "last", pull=pull).compile()
    data = simulated(model, 60, forward=True, ctrl=[-0.5, 0.0, 0.0, 0.0])
    view = view_sheath(model, data, "t")
    assert (view.slip == 1.0)[view.bend_angle > 0.0].all()
    ratio = np.exp(-0.3 * view.bend_angle.sum())
    assert ratio < 0.96
    assert view.output_tension == pytest.approx(view.input_tension * ratio, rel=1e-9)
    assert view.input_tension == pytest.approx(-data.actuator_force[0], rel=1e-9)
    shown = data.sensor("tension").data
    assert shown == pytest.approx(view.tension)
    ends = [float(data.sensor(f"{end}_tension").data[0]) for end in ("input", "output")]
    assert ends == [shown[0], shown[-1]]
    drawn = [data.site(name).xpos for name in (PATHS[path].split()[-1], PATHS[path].split()[0])]
    np.testing.assert_array_equal(view.positions[[-1, 0]], drawn)


def test_the_other_end_is_another_input():
    """The flag has an effect: friction takes the force at the end that is not pulled."""
    models = [arm("sites", "first").compile(), arm("sites", "last").compile()]
    spec = arm("sites", "last")
    remove_friction(spec, "t")
    add_friction(spec, "t", friction=0.3, sensors=SENSORS)
    assert "input_end" not in spec.plugin("t_sheath").config
    models.append(spec.compile())
    spec.plugin("t_sheath").config = spec.plugin("t_sheath").config | {"input_end": "first"}
    models.append(spec.compile())
    first, last, wrong, written = (motion(model)[0][0] for model in models)
    assert np.array_equal(wrong, written)
    assert np.abs(first - last).max() < 1e-10
    assert np.abs(wrong - last).max() > 0.01


@hands_on_plugin_states
def test_a_state_of_the_other_end_is_found_out_and_laid_anew():
    spec = arm("both", "first")
    model = spec.compile()
    _, data = motion(model, 100)
    sheath = spec.plugin("t_sheath")
    sheath.config = sheath.config | {"input_end": "last"}
    model, data = spec.recompile(model, data)
    mujoco.mj_step(model, data)
    assert view_sheath(model, data, "t").rebound == 1
    assert sheath_view(model, data, "t_sheath").state.input_at_last == 1.0
    fresh = mujoco.MjData(spec.compile())
    fresh.qpos[:] = data.qpos
    for each in (data, fresh):
        mujoco.mj_forward(model, each)
    assert view_sheath(model, data, "t").positions[0] == pytest.approx(data.site("e").xpos)


def test_it_stays_the_last_site_of_an_attached_tendon():
    parent = mujoco.MjSpec()
    parent.option.timestep = 0.001
    for k, prefix in enumerate(("left_", "right_")):
        frame = parent.worldbody.add_frame(pos=[0.0, 8.0 * k, 0.0])
        parent.attach(arm("both", "last"), prefix=prefix, frame=frame)
    model, alone = parent.compile(), arm("both", "first").compile()
    assert {sheath.tendon for sheath in sheaths(model).values()} == {"left_t", "right_t"}
    controls, data, other = smooth_controls(alone, 500), mujoco.MjData(model), mujoco.MjData(alone)
    for row in controls:
        data.ctrl[:], other.ctrl[:] = np.tile(row, 2), row
        mujoco.mj_step(model, data)
        mujoco.mj_step(alone, other)
    for side in ("left_t", "right_t"):
        tension = view_sheath(model, data, side).tension
        np.testing.assert_allclose(tension, view_sheath(alone, other, "t").tension, rtol=SUMS)


def branched(sensor="", **law):
    """A branched tendon ``t`` and a plain one ``u``, with a sheath where a law is given."""
    return rope(
        "a; k .1 0 0",
        "e; f 0 .1 0",
        "a k /2 k e",
        body='pos=".2 0 0"',
        head=sheath(friction=0.1, **law) if law else "",
        tendons=spatial("u", "e k a"),
        actuator='<motor tendon="t"/><motor tendon="u"/>',
        sensor=(shown() if law else "") + sensor,
    )


def test_branches_are_refused_with_the_place_and_the_way_out():
    facts = "tendon 't'", "pulley", "'k'", "draw each branch from its input"
    spec = mujoco.MjSpec.from_string(branched())
    before = spec.to_xml()
    with refusing(InvalidValueError, *facts):
        add_friction(spec, "t", friction=0.1, input_end="last")
    assert spec.to_xml() == before
    with refusing(ValueError, *facts):
        compiled(branched(tendon="t", input_end="last"))
    with pytest.warns(TendonWarning, match="left as they are: 't': branches at a pulley"):
        add_friction(spec, "*", friction=0.1, input_end="last")
    assert {sheath.tendon for sheath in sheaths(spec.compile()).values()} == {"u"}


def test_a_sensor_takes_no_input_end():
    more = config(tendon="u", sensor="tension", input_end="last")
    with refusing(ValueError, "a sensor takes no input_end"):
        compiled(branched(f'<plugin plugin="tendon_mj.sheath">{more}</plugin>', tendon="u"))
