"""Split guides: the same path, lumped less; eyelets stay where they are."""

from __future__ import annotations

import pickle

import mujoco
import numpy as np
import pytest

from tendon_mj.attach import add_friction, add_tendon, arc_points
from tendon_mj.attach.cable_drive import add_cable_drive
from tendon_mj.lab.replay import Simulator, rollout_named_sensors
from tendon_mj.lab.replay.finer_guides import split_guides
from tendon_mj.models import Bench, Joint, build_bench, build_joint
from tests.lab.diagnosis.toy import bench_recording

FEW, MANY = 8, 96
LEVER = """
<mujoco>
  <option timestep="1e-5"/>
  <worldbody>
    <site name="a"/><site name="b" pos="0.1 0 0"/><site name="c" pos="0.1 0.1 0"/>
    <body pos="0.1 0.2 0">
      <joint name="lever" axis="0 0 1"/><geom size="0.01"/><site name="d" pos="0.05 0 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="t">
      <site site="a"/><site site="b"/><site site="c"/><site site="d"/>
    </spatial>
  </tendon>
</mujoco>
"""


def path_of(model, tendon):
    """Length [m] and bends [rad] of a tendon over sites in the reference pose."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    k = model.tendon(tendon).id
    first, count = model.tendon_adr[k], model.tendon_num[k]
    points = data.site_xpos[model.wrap_objid[first : first + count]]
    ways = np.diff(points, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    bends = np.arccos(np.clip((ways[1:] * ways[:-1]).sum(axis=1), -1.0, 1.0))
    return float(data.tendon(tendon).length[0]), bends


@pytest.mark.parametrize("pieces", [2, 4])
@pytest.mark.parametrize(
    ("build", "tendons"),
    [
        (lambda: build_bench(Bench(guides=FEW)), ["tendon"]),
        (lambda: build_joint(Joint(guides=FEW)), ["tendon_1", "tendon_2"]),
    ],
)
def test_a_path_keeps_its_length_and_shares_each_bend_evenly(build, tendons, pieces):
    coarse, fine = build().compile(), split_guides(build(), pieces)
    for tendon in tendons:
        (length, bends), (split_length, split_bends) = (
            path_of(coarse, tendon),
            path_of(fine, tendon),
        )
        assert split_length == pytest.approx(length, rel=1e-9)
        np.testing.assert_allclose(split_bends, np.repeat(bends / pieces, pieces), rtol=1e-6)


def test_tensions_come_as_near_to_a_smooth_sheath_as_with_as_many_guides():
    drive = 1e-3 * np.sin(np.arange(0.0, 4.0, Bench().timestep) * 5.0) * np.linspace(0.3, 1.0, 8000)
    rig = {"friction": 0.3, "bend": 4.0}

    def tension(model):
        return rollout_named_sensors(model, drive)["input_tension"]

    smooth = tension(build_bench(Bench(guides=MANY, **rig)).compile())
    few = build_bench(Bench(guides=FEW, **rig))
    error = np.std(tension(few.compile()) - smooth)
    assert np.std(tension(split_guides(few, 4)) - smooth) < 0.15 * error


@pytest.mark.parametrize(("tilt", "split"), [(0.0, True), (0.8e-4, True), (1.2e-4, False)])
def test_a_path_on_a_body_between_ends_that_move_along_it_keeps_them(tilt, split):
    spec = mujoco.MjSpec()
    spec.option.timestep = 1e-5
    spec.worldbody.add_body(pos=[0.1, 0.2, 0.3], quat=[0.6, 0.8, 0.0, 0.0])
    holder = spec.worldbody.add_body(name="holder", pos=[0.0, 0.1, 0.0], quat=[0.8, 0.0, 0.6, 0.0])
    points = arc_points(0.4, 2.0, FEW)
    for k, end in ((0, points[0]), (1, points[-1])):
        body = spec.worldbody.add_body(name=f"end_{k}", pos=end)
        along = points[1] - points[0] if k == 0 else points[-1] - points[-2]
        across = np.linalg.norm(along) * np.array([0.0, 1.0, 0.0])
        axis = along + tilt * across
        body.add_joint(name=f"end_{k}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        body.add_geom(size=[0.01, 0, 0])
        body.add_site(name=f"e{k}")
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, holder.quat)
    names = ["e0", *(f"guide_{k}" for k in range(FEW)), "e1"]
    for name, point in zip(names[1:-1], points[1:-1], strict=True):
        holder.add_site(name=name, pos=(point - holder.pos) @ turn.reshape(3, 3))
    add_tendon(spec, "t", names)
    add_friction(spec, "t", friction=0.1, axial_stiffness=1e4, pretension=10.0)
    length, bends = path_of(spec.compile(), "t")
    split_length, split_bends = path_of(split_guides(spec, 2), "t")
    assert split_length == pytest.approx(length, rel=1e-9)
    assert (split_bends.size == 2 * bends.size) == split
    assert split_bends.sum() == pytest.approx(bends.sum(), rel=1e-9)


def test_a_site_whose_neighbour_turns_away_stays_an_eyelet():
    spec = mujoco.MjSpec.from_string(LEVER)
    add_friction(spec, "t", friction=0.1, axial_stiffness=1e4, pretension=10.0)
    before = path_of(spec.compile(), "t")[1]
    np.testing.assert_allclose(path_of(split_guides(spec, 4), "t")[1], before)


def test_a_simulator_splits_the_model_that_its_recordings_name():
    time = np.arange(0.0, 1.0, 0.01)
    made = bench_recording("r", time, 1e-3 * np.sin(6.0 * time), 0.02, ["input_tension_N"])
    own = Simulator([made], threads=1)
    split = own.split(2)
    assert split.model.nwrap > own.model.nwrap
    (whole,), (finer,) = own([{}]), split([{}])
    column = "input_tension_N"
    assert 0.0 < np.abs(finer[0][column] - whole[0][column]).max() < 0.5
    ((sent,),) = pickle.loads(pickle.dumps(split))([{}])
    assert np.array_equal(sent[column], finer[0][column])
    given = Simulator([made], own.model, threads=1)
    assert given.split(2) is given


@pytest.mark.parametrize("pieces", [2, 4])
def test_a_straight_path_that_moves_with_its_motor_shares_its_undrawn_bend_evenly(pieces):
    spec = mujoco.MjSpec.from_string(LEVER)
    spec.add_actuator(name="m", target="lever", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    cable = {"motor": True, "axial_stiffness": 1e4, "length": 0.6, "pretension": 10.0}
    add_cable_drive(spec, "m", radius=0.01, bend=3.0, friction=0.2, armature=1e-3, **cable)
    coarse = spec.copy().compile()
    split = split_guides(spec, pieces)
    guides = coarse.tendon_num[coarse.tendon("lever_cable").id] - 2
    k = split.tendon("lever_cable").id
    first, count = split.tendon_adr[k], split.tendon_num[k]
    assert count == pieces * guides + 2
    along = split.site_pos[split.wrap_objid[first : first + count], 0]
    cells = [0.0, *((np.arange(pieces * guides) + 0.5) / (pieces * guides)), 1.0]
    assert along == pytest.approx(0.6 * np.array(cells))


def test_a_path_that_folds_back_keeps_its_length():
    spec = mujoco.MjSpec.from_string(LEVER)
    spec.site("c").pos = [0.05, 0.0, 0.0]
    add_friction(spec, "t", friction=0.1, axial_stiffness=1e4, pretension=10.0, extra_bend=1.0)
    length = path_of(spec.compile(), "t")[0]
    assert path_of(split_guides(spec, 4), "t")[0] == pytest.approx(length, rel=1e-9)


def test_a_cable_that_is_not_drawn_keeps_its_guide():
    spec = mujoco.MjSpec.from_string(LEVER)
    spec.add_actuator(target="lever", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    add_cable_drive(spec, "*", radius=0.01, bend=3.0, friction=0.1)
    stock = spec.copy().compile()
    split = split_guides(spec, 4)
    assert split.nwrap == stock.nwrap
    assert split.npluginstate == stock.npluginstate
