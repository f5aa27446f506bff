"""Sensor readings of a tendon that is drawn through a sheath."""

import mujoco
import numpy as np
import pytest

from tendon_mj.models import Bench, build_bench
from tendon_mj.theory import output_tension
from tests.plugin.rigs import arm, fixed_sheaths, run

GUIDES = [1, 2, 5, 16, 64]


def drawn(model, data, reach, steps):
    """Ramp the reel and return T_in, T_out once a second way has been gone."""
    start = float(data.ctrl[0])

    def move(k):
        data.ctrl[0] = start + reach * (k + 1) / steps

    run(model, data, steps, move)
    return data.sensor("input_tension").data[0], data.sensor("output_tension").data[0]


@pytest.mark.parametrize("guides", GUIDES)
@pytest.mark.parametrize("bend", [0.5, 3.0])
def test_a_sliding_tendon_loses_e_to_the_minus_lambda_in_both_directions(guides, bend):
    bench = Bench(guides=guides, bend=bend)
    model = build_bench(bench).compile()
    data = mujoco.MjData(model)
    pulled, far = drawn(model, data, 0.003, 600)
    assert far / pulled == pytest.approx(np.exp(-bench.exponent), rel=1e-9)
    loosened, far = drawn(model, data, -0.002, 600)
    assert far / loosened == pytest.approx(np.exp(bench.exponent), rel=1e-9)
    assert far > loosened > 0.0


def test_the_joint_driven_spool_and_the_reel_draw_alike():
    spec = build_bench(Bench(guides=5))
    model = spec.compile()
    body = spec.worldbody.add_body(name="motor")
    body.add_joint(name="motor", axis=[0, 0, 1])
    body.add_geom(size=[0.01, 0, 0], mass=1.0, contype=0, conaffinity=0)
    spec.plugin("sheath").config = spec.plugin("sheath").config | {
        "reel_joint": "motor",
        "reel_radius": "0.02",
    }
    spooled = spec.compile()
    one, other = mujoco.MjData(model), mujoco.MjData(spooled)
    at = spooled.joint("motor").qposadr[0]
    for k in range(300):
        one.ctrl[0] = 1e-5 * k
        other.qpos[at], other.qvel[at] = 1e-5 * k / 0.02, 0.0
        for m, d in ((model, one), (spooled, other)):
            mujoco.mj_step(m, d)
        for name in ("input_tension", "output_tension", "reel_displacement"):
            assert other.sensor(name).data == pytest.approx(one.sensor(name).data, rel=1e-9)


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
        laws.append(
            {
                "guides": guides,
                "bend": rng.uniform(0.3, min(6.0, 2.8 * guides)),
                "friction": rng.uniform(0.02, 0.4),
                "pretension": rng.uniform(10.0, 40.0),
            }
        )
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
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points = data.site_xpos[model.wrap_objid]
    legs = np.diff(points, axis=0)
    legs /= np.linalg.norm(legs, axis=1)[:, None]
    angles = np.arccos(np.sum(legs[1:] * legs[:-1], axis=1))
    np.testing.assert_allclose(data.sensor("bend_angle").data, angles, rtol=1e-9)
