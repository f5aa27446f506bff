"""Angles and sites of a path: the arctangent against the C library's, sites on one spot."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tendon_mj.plugin.sheath_plugin.path import arctangent
from tests.plugin.rigs import unpacked

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
    assert (np.abs(angle - expected) <= 2.0 * np.spacing(expected)).all()


def test_it_grows_with_the_direction_across_the_seams_of_its_ranges():
    for seam in np.pi * np.array([1.0, 3.0, 5.0, 7.0]) / 8.0:
        around = seam + 1e-9 * np.linspace(-1.0, 1.0, 201)
        angle = [arctangent(np.sin(direction), np.cos(direction)) for direction in around]
        assert (np.diff(angle) > 0.0).all()


def test_nothing_has_no_direction():
    assert arctangent(0.0, 0.0) == 0.0


SLIDER = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <site name="a"/><site name="g" pos=".2 0 0"/><site name="h" pos=".2 0 0"/>
    <body name="load" pos=".3 .2 0">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
      <geom size=".01" mass="1" contype="0" conaffinity="0"/><site name="b"/>
    </body>
  </worldbody>
  <tendon><spatial name="tendon">{path}</spatial></tendon>
  {more}
</mujoco>
"""
MOTOR = '<actuator><motor name="motor" tendon="tendon" gear="-1"/></actuator>'


def rig(sites, friction, is_driven):
    path = "".join(f'<site site="{site}"/>' for site in sites)
    spec = mujoco.MjSpec.from_string(SLIDER.format(path=path, more=MOTOR if is_driven else ""))
    law = {} if is_driven else {"axial_stiffness": 1e3, "pretension": 5.0}
    return add_friction(spec, "tendon", friction=friction, **law).compile()


def check(model, data):
    scalars, segments, _ = unpacked(model, data)
    assert np.isfinite(data.sensordata).all()
    assert np.isfinite(segments["tension"]).all()
    assert np.isfinite(data.qacc).all()
    assert scalars.unsolved == 0.0


@pytest.mark.parametrize("is_driven", [False, True])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("sites", ["aghb", "agab", "ghb", "agahb", "agb"])
def test_sites_on_one_spot_have_tensions(sites, friction, is_driven):
    model = rig(sites, friction, is_driven)
    data = mujoco.MjData(model)
    data.ctrl[:] = 5.0
    for _ in range(20):
        mujoco.mj_step(model, data)
        check(model, data)


@pytest.mark.parametrize("is_driven", [False, True])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("sites", ["agb", "ahgb", "agbh"])
def test_a_body_may_move_onto_a_guide_and_away(sites, friction, is_driven):
    model = rig(sites, friction, is_driven)
    data = mujoco.MjData(model)
    data.ctrl[:] = 5.0
    for x, y in ([0.0, 0.0], [-0.1, -0.2], [-0.1, -0.2], [-0.1, -0.1999], [0.0, 0.0]):
        data.qpos[:], data.qvel[:] = (x, y), 0.0
        mujoco.mj_forward(model, data)
        check(model, data)
        mujoco.mj_step(model, data)
        check(model, data)
