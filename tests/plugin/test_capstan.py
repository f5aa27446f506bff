"""Bends of a path, and sensor readings of a tendon that is drawn through a sheath."""

import math

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, view_sheath
from tendon_mj.plugin.sheath_plugin.vectors import arctangent
from tendon_mj.theory import output_tension
from tests.rigs import (
    BEND,
    LENGTH,
    PRETENSION,
    STILL,
    Drives,
    arm,
    fixed_sheaths,
    rope,
    simulated,
    unpacked,
)


@pytest.mark.parametrize("guides", [1, 2, 5, 16, 64])
@pytest.mark.parametrize("bend", [0.5, 3.0])
def test_a_sliding_tendon_loses_e_to_the_minus_lambda_in_both_directions(guides, bend):
    drives = Drives(guides=guides, bend=bend, friction=0.15)
    for speed in (0.02, -0.02):
        assert drives.draw(speed, 600).min() > 0.0
        assert drives.loss == pytest.approx(np.sign(speed) * 0.15 * bend, rel=1e-9)


def test_a_joint_winds_as_a_reel_does():
    drives = Drives(guides=5)
    law = {"guides": 5, "bend": BEND, "length": LENGTH, "friction": 0.2, "pretension": PRETENSION}
    model = fixed_sheaths([law])
    data = mujoco.MjData(model)
    for wound in 1e-5 * np.arange(300):
        data.ctrl[0] = wound
        mujoco.mj_step(model, data)
        assert data.sensordata[:2] == pytest.approx(drives.step(wound), rel=1e-9)
        shown = drives.data.sensor("reel_displacement").data[0]
        assert shown == pytest.approx(wound, rel=1e-9)


def test_a_tendon_held_by_static_friction_breaks_loose_and_slides_on_at_the_dynamic():
    law = {"guides": 1, "bend": 1.0, "friction": 0.2, "static_friction": 0.4, "pretension": 20.0}
    model = fixed_sheaths([law])
    data = mujoco.MjData(model)
    ratios = []
    for _ in range(400):
        data.ctrl[0] += 2e-6
        mujoco.mj_step(model, data)
        ratios.append(data.sensordata[0] / data.sensordata[1])
    broke = int(np.argmax(ratios))
    assert np.exp(0.39) < ratios[broke] <= np.exp(0.4) * (1 + 1e-12)
    np.testing.assert_allclose(ratios[broke + 1 :], np.exp(0.2), rtol=1e-9)
    # at rest again it takes the static friction to let it go
    mujoco.mj_step(model, data, 3)
    data.ctrl[0] += 8e-6
    mujoco.mj_step(model, data)
    assert np.exp(0.201) < data.sensordata[0] / data.sensordata[1] < np.exp(0.4)


@pytest.mark.parametrize("seed", range(5))
def test_two_hundred_random_histories_are_the_play_operator(seed):
    rng = np.random.default_rng(seed)
    laws, histories = [], 40
    for _ in range(histories):
        guides = int(rng.choice([1, 2, 3, 5, 8]))
        bend, friction = rng.uniform(0.3, min(6.0, 2.8 * guides)), rng.uniform(0.02, 0.4)
        law = {"bend": bend, "friction": friction, "pretension": rng.uniform(10.0, 40.0)}
        laws.append({"guides": guides, **law})
    model = fixed_sheaths(laws)
    data = mujoco.MjData(model)
    first = np.arange(histories) * 2  # T_in and T_out of one sheath after the other
    guides = np.array([law["guides"] for law in laws])
    rest = np.array([law["pretension"] for law in laws])
    mujoco.mj_forward(model, data)
    pulled, let_out = [], []
    way = rng.choice([-1.0, 1.0], histories)
    for _ in range(400):
        tension = data.sensordata[first]
        turn = (rng.random(histories) < 0.03) | (tension > 5 * rest) & (way > 0)
        turn |= (tension < 0.3 * rest) & (way < 0)
        way = np.where(turn, -way, way)
        # at most half of the tension that the first segment bears, so that it stays taut
        step = rng.uniform(0.0, 0.5, histories) * tension / 20e3 * 0.25 / guides
        data.ctrl[:] += way * step
        mujoco.mj_step(model, data)
        pulled.append(data.sensordata[first].copy())
        let_out.append(data.sensordata[first + 1].copy())
    lam = np.array([law["friction"] * law["bend"] for law in laws])
    expected = output_tension(np.array(pulled), lam, rest)
    np.testing.assert_allclose(np.array(let_out), expected, rtol=1e-6)
    moved = np.abs(np.diff(expected, axis=0)) > 0.0
    assert np.median(moved.sum(axis=0)) > 100, "most of them slide through and back"


def test_bends_are_shown_guide_by_guide():
    model = arm()
    data = simulated(model)
    points = data.site_xpos[model.wrap_objid]
    legs = np.diff(points, axis=0)
    legs /= np.linalg.norm(legs, axis=1)[:, None]
    angles = np.arccos(np.sum(legs[1:] * legs[:-1], axis=1))
    np.testing.assert_allclose(data.sensor("bend_angle").data, angles, rtol=1e-9)


FRICTION, RADIUS, STRAIGHT = 0.2, 0.03, 0.05
TURNS = [10, 45, 90, 180, 270, 360, 450, 540, 630, 720]  # [deg]
PULLS = {"in": ((-20.0, 0.0), 1.0), "out": ((-5.0, 100.0), -1.0)}


def row_of_drums(turn, drums):
    """A spec: a tendon that turns by ``turn``/drums to the left on each drum, and pulls on a mass.

    Between two drums it runs straight over a site; the mass slides along its last stretch.
    """
    each, point, heading = turn / drums, np.zeros(2), 0.0
    sites, geoms = [point], []
    for _ in range(drums):
        along = np.array([math.cos(heading), math.sin(heading)])
        left = np.array([-along[1], along[0]])
        centre = point + STRAIGHT * along + RADIUS * left
        heading += each
        along = np.array([math.cos(heading), math.sin(heading)])
        out = np.array([along[1], -along[0]])
        middle = centre + 2.0 * RADIUS * np.array(
            [math.sin(heading - each / 2.0), -math.cos(heading - each / 2.0)]
        )
        point = centre + RADIUS * out + STRAIGHT * along
        geoms.append((centre, middle))
        sites.append(point)
    drawn = "".join(
        f'<geom name="g{k}" type="cylinder" size="{RADIUS} .01" pos="{at[0]} {at[1]} 0"/>'
        for k, (at, _) in enumerate(geoms)
    )
    words = "s0" + "".join(f" g{k}@m{k} s{k + 1}" for k in range(drums))
    places = ";".join(
        [f"s{k} {p[0]} {p[1]} 0" for k, p in enumerate(sites[:-1])]
        + [f"m{k} {m[0]} {m[1]} 0" for k, (_, m) in enumerate(geoms)]
    )
    last = sites[-1]
    text = rope(
        places,
        f"s{drums}",
        words,
        body=f'pos="{last[0]} {last[1]} 0"',
        joint=f'name="x" type="slide" axis="{along[0]} {along[1]} 0" damping="40"',
        geom='size=".005" mass=".3"',
        option=STILL,
        world=drawn,
        actuator='<motor tendon="t"/><motor joint="x"/>',
    )
    return mujoco.MjSpec.from_string(text)


def slide(spec, pull, **values):
    """View of the sheath some steps later, as the tendon slides steadily."""
    model = add_friction(spec, "t", friction=FRICTION, **values).compile()
    data = simulated(model, 40, forward=True, ctrl=pull)
    return view_sheath(model, data, "t")


@pytest.mark.parametrize("arc_guides", [1, 4])
@pytest.mark.parametrize("way", PULLS)
@pytest.mark.parametrize("degrees", TURNS)
def test_drums_one_behind_the_other(degrees, way, arc_guides):
    pull, sense = PULLS[way]
    turn = math.radians(degrees)
    spec = row_of_drums(turn, drums=math.ceil(degrees / 90))
    view = slide(spec, pull, arc_guides=arc_guides)
    assert view.bend_angle.sum() == pytest.approx(turn, rel=1e-8)
    assert (view.slip[view.bend_angle > 1e-6] == sense).all()
    expected = math.exp(sense * FRICTION * view.bend_angle.sum())
    assert view.input_tension / view.output_tension == pytest.approx(expected, rel=1e-9)
    assert view.unsolved == 0


DIRECTIONS = np.concatenate(
    [
        np.linspace(0.0, np.pi, 20_001),
        np.logspace(-300.0, 0.0, 2_000),
        np.pi - np.logspace(-15.0, 0.0, 2_000),
    ]
)


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e6])
def test_the_angle_is_that_of_the_c_library_but_for_two_roundings(length):
    y, x = length * np.abs(np.sin(DIRECTIONS)), length * np.cos(DIRECTIONS)
    angle = np.array([arctangent(*direction) for direction in zip(y, x, strict=True)])
    expected = np.arctan2(y, x)
    assert arctangent(0.0, 0.0) == 0.0
    for seam in np.pi * np.array([1.0, 3.0, 5.0, 7.0]) / 8.0:  # of its ranges
        around = seam + 1e-9 * np.linspace(-1.0, 1.0, 201)
        grows = [arctangent(length * np.sin(a), length * np.cos(a)) for a in around]
        assert (np.diff(grows) > 0.0).all()
    assert (np.abs(angle - expected) <= 2.0 * np.spacing(expected)).all()


def rig(sites, friction, is_driven):
    text = rope(
        "a; g .2 0 0; h .2 0 0",
        "b",
        " ".join(sites),
        body='pos=".3 .2 0"',
        joint='<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>',
        geom='size=".01" mass="1"',
        option='gravity="0 0 0"',
        actuator='<motor tendon="t" gear="-1"/>' if is_driven else "",
    )
    law = {} if is_driven else {"axial_stiffness": 1e3, "pretension": 5.0}
    return add_friction(mujoco.MjSpec.from_string(text), "t", friction=friction, **law).compile()


@pytest.mark.parametrize("is_driven", [False, True])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("sites", ["aghb", "agab", "ghb", "agahb", "agb", "ahgb", "agbh"])
def test_sites_on_one_spot_have_tensions(sites, friction, is_driven):
    """From the start, and where a body moves onto a guide and away."""
    model = rig(sites, friction, is_driven)
    data = mujoco.MjData(model)
    data.ctrl[:] = 5.0
    for place in (*[None] * 20, (0, 0), (-0.1, -0.2), (-0.1, -0.2), (-0.1, -0.1999), (0, 0)):
        if place is not None:
            data.qpos[:], data.qvel[:] = place, 0.0
        mujoco.mj_forward(model, data)
        mujoco.mj_step(model, data)
        scalars, segments, _ = unpacked(model, data)
        assert np.isfinite(data.sensordata).all()
        assert np.isfinite(segments["tension"]).all()
        assert np.isfinite(data.qacc).all()
        assert scalars.unsolved == 0.0
