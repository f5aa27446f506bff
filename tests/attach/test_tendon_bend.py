"""Bend of tendons, against the arcs on which MuJoCo lays them."""

import mujoco
import numpy as np
import pytest

from tendon_mj.attach.tendon_bend import (
    bend_at,
    branch_bend,
    extreme_poses,
    leading_joints,
    sampled_poses,
    unswept_joints,
)
from tests.rigs import MUJOCO

RADIUS = 0.1
DRUM = """
<mujoco>
  <worldbody>
    <geom name="drum" type="{shape}" size="{radius} 0.2"/>
    <site name="a" pos="{ax} {ay} 0"/><site name="b" pos="{bx} {by} 0"/>
    <site name="side" pos="{side} 0 0"/>
    <body><joint name="j" range="-40 70"/><geom size=".01"/><site name="c" pos="1 0 0"/></body>
    <body><joint name="slide" type="slide" range="0 2"/><geom size=".01"/></body>
    <body><joint name="free_to_turn"/><geom size=".01"/></body>
  </worldbody>
  <tendon>
    <spatial><site site="a"/><geom geom="drum" sidesite="side"/><site site="b"/></spatial>
    <spatial><site site="side"/><site site="c"/></spatial>
    {more}
  </tendon>
</mujoco>
"""


def drum(a, b, shape="cylinder", side=-0.2, more=""):
    (ax, ay), (bx, by) = a, b
    text = DRUM.format(shape=shape, radius=RADIUS, ax=ax, ay=ay, bx=bx, by=by, side=side, more=more)
    return mujoco.MjModel.from_xml_string(text)


def bends(model, qpos=None, tendons=(0,)):
    data = mujoco.MjData(model)
    return bend_at(model, data, model.qpos0 if qpos is None else qpos, tendons), data


@pytest.mark.parametrize("shape", ["cylinder", "sphere"])
@pytest.mark.parametrize("height", [0.02, 0.05, 0.09, 0.1, 0.11, 0.2, 0.29])
@pytest.mark.parametrize("distance", [0.12, 0.3, 1.0])
def test_the_bend_over_a_drum_is_its_arc_over_the_radius(shape, height, distance):
    # from less than half a turn, where the ends are further apart than the drum is wide, to more
    if height == RADIUS and MUJOCO < (3, 16):
        pytest.skip("MuJoCo before 3.16 computes an arc of half a turn to 1e-8 only")
    model = drum((distance, -height), (distance, height), shape)
    (bend,), data = bends(model)
    points = data.wrap_xpos.reshape(-1, 3)[:4]
    straight = np.linalg.norm(points[1] - points[0]) + np.linalg.norm(points[3] - points[2])
    arc = data.ten_length[0] - straight
    assert bend == pytest.approx(arc / RADIUS, rel=1e-9)
    assert (bend > np.pi) == (height < RADIUS) or height == RADIUS


def test_a_drum_that_is_not_touched_bends_nothing():
    assert bends(drum((0.5, -0.3), (0.5, 0.3), side=0.2))[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("height", [0.11, 0.15, 0.2, 0.3])
@pytest.mark.parametrize("shift", [0.0, 0.013, 0.1])
def test_inside_a_drum_the_tendon_bends_at_one_point(height, shift):
    model = drum((shift - 0.3, height), (shift + 0.3, height), side=0.0)
    (bend,), data = bends(model)
    assert data.ten_wrapnum[0] == 4, "it is drawn down to the drum"
    points = data.wrap_xpos.reshape(-1, 3)[:4]
    before, after = points[1] - points[0], points[3] - points[2]
    cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
    assert 0.01 < bend < np.pi
    assert np.cos(bend) == pytest.approx(cosine, abs=1e-12)


@pytest.mark.parametrize("noise", [-1e-17, 0.0, 1e-17])
def test_tangent_points_that_are_one_but_for_rounding_are_a_corner(noise):
    points = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [noise, -noise, 0.0], [0.0, 1.0, 0.0]])
    assert branch_bend(points, np.array([-1, 0, 0, -1])) == pytest.approx(np.pi / 2)


def test_corners_add_up_in_whatever_plane_they_are():
    sites = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]]  # two on a spot
    spec = mujoco.MjSpec()
    tendon = spec.add_tendon(name="t")
    for k, pos in enumerate(sites):
        spec.worldbody.add_site(name=f"s{k}", pos=pos)
        tendon.wrap_site(f"s{k}")
    bend, _ = bends(spec.compile())
    assert bend == pytest.approx(1.5 * np.pi)


def test_over_pulleys_the_most_bent_branch_counts():
    a, b = '<site site="a"/>', '<site site="b"/>'
    over = '<geom geom="drum" sidesite="side"/>'
    more = f'<spatial>{a}{b}<pulley divisor="2"/>{a}{over}{b}<pulley divisor="2"/>{b}{a}</spatial>'
    model = drum((0.3, -0.05), (0.3, 0.05), more=more)
    angles, _ = bends(model, tendons=(0, 2))
    assert angles[1] == angles[0] > np.pi


def test_poses_reach_the_ends_of_every_range_and_no_further():
    model = drum((1.0, -0.1), (1.0, 0.1))
    poses = sampled_poses(model)
    np.testing.assert_array_equal(poses, sampled_poses(model))
    np.testing.assert_array_equal(poses[0], model.qpos0)
    for joint in (0, 1):
        assert [poses[:, joint].min(), poses[:, joint].max()] == list(model.jnt_range[joint])
    assert [poses[:, 2].min(), poses[:, 2].max()] == pytest.approx([-np.pi, np.pi], rel=0.1)
    assert len(sampled_poses(mujoco.MjModel.from_xml_string("<mujoco/>"))) == 1


# straight at qpos0; it bends where it passes the joint, by the angle between the links
ARM = """
<mujoco>
  <worldbody>
    <site name="a" pos="-1 0 0"/><site name="b"/>
    <body>{joint}<geom size=".01"/><site name="c" pos="1 0 0"/></body>
  </worldbody>
  <tendon><spatial><site site="a"/><site site="b"/><site site="c"/></spatial></tendon>
</mujoco>
"""


@pytest.mark.parametrize(
    ("joint", "most"),
    [
        ('<joint type="ball" range="0 70"/>', np.deg2rad(70)),
        ('<joint type="ball"/>', np.pi),
        ('<joint axis="0 0 1"/>', np.pi),
        ('<joint axis="0 0 1" range="-20 50"/>', np.deg2rad(50)),
        ('<joint axis="1 0 0"/>', 0.0),
        ('<joint type="slide" axis="1 0 0"/>', 0.0),
        ("<freejoint/>", np.pi),
    ],
)
def test_a_joint_bends_its_tendon_by_as_much_as_it_turns(joint, most):
    model = mujoco.MjModel.from_xml_string(ARM.format(joint=joint))
    poses = sampled_poses(model)
    angles = [bends(model, qpos)[0][0] for qpos in poses]
    assert angles[0] == pytest.approx(0.0, abs=1e-12)
    assert max(angles) == pytest.approx(most, rel=0.1, abs=1e-7)
    assert max(angles) <= most + 1e-7
    turned = poses[:, -4:]
    if poses.shape[1] >= 4:
        np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1.0)
    assert unswept_joints(model) == ([0] if "slide" in joint or "free" in joint else [])


def test_all_joints_are_at_their_ends_at_once_too():
    links = 6
    inner = '<joint axis="0 0 1" range="0 30"/><geom size=".01"/><site name="s{}" pos="{} 0 0"/>'
    body = "".join(f'<body pos="{min(k, 1)} 0 0">' + inner.format(k, 1) for k in range(links))
    sites = "".join(f'<site site="s{k}"/>' for k in range(links))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><site name="a" pos="-1 0 0"/><site name="b"/>{body}'
        f'{"</body>" * links}</worldbody><tendon><spatial><site site="a"/><site site="b"/>'
        f"{sites}</spatial></tendon></mujoco>"
    )
    most = max(bends(model, qpos)[0][0] for qpos in sampled_poses(model))
    assert most == pytest.approx(links * np.deg2rad(30))


def test_a_coupled_joint_follows():
    two = '<joint name="{}" axis="0 0 1" range="0 1"/><geom size=".01"/>'
    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco><compiler angle="radian"/>
      <worldbody><body>{two.format("p")}<body>{two.format("d")}</body></body></worldbody>
      <equality>
        <joint joint1="d" joint2="p" polycoef=".1 .5 .2 0 0"/>
      </equality>
    </mujoco>""")
    p, d = sampled_poses(model).T
    np.testing.assert_allclose(d, 0.1 + 0.5 * p + 0.2 * p**2)
    assert (p.min(), p.max()) == (0.0, 1.0)


def test_balls_are_swept_until_the_tendon_bends_most_and_least():
    text = ARM.format(joint='<joint type="ball" range="0 70"/>').replace(
        '<site name="c" pos="1 0 0"/>',
        '<site name="c" pos="1 .3 0"/><body pos="2 0 0"><joint type="ball" range="0 40"/>'
        '<geom size=".01"/><site name="d"/><site name="e" pos="1 0 .2"/></body>',
    )
    model = mujoco.MjModel.from_xml_string(
        text.replace('<site site="c"/>', "".join(f'<site site="{s}"/>' for s in "cde"))
    )
    poses = sampled_poses(model)
    sampled = np.array([bends(model, qpos)[0][0] for qpos in poses])
    most, least = extreme_poses(model, 0, {0, 1}, poses, sampled)
    rng, dense = np.random.default_rng(1), []
    for _ in range(2_000):
        qpos = model.qpos0.copy()
        for at, largest in ((0, 70), (4, 40)):
            axis = rng.normal(size=3)
            turn = np.deg2rad(largest) * rng.choice([1.0, rng.random()])
            mujoco.mju_quatIntegrate(qpos[at : at + 4], axis / np.linalg.norm(axis), turn)
        dense.append(bends(model, qpos)[0][0])
    assert bends(model, most)[0][0] > max(dense) - 0.05
    assert bends(model, least)[0][0] < min(dense) + 0.05
    turns = 2.0 * np.arccos(np.abs(np.array([most, least])[:, ::4]))
    assert (turns <= np.deg2rad([70, 40]) + 1e-6).all()


def test_where_hinges_alone_move_the_tendon_samples_do():
    model = mujoco.MjModel.from_xml_string(ARM.format(joint='<joint axis="0 0 1" range="-20 50"/>'))
    poses = sampled_poses(model)
    assert not len(extreme_poses(model, 0, {0}, poses, np.zeros(len(poses))))


def test_what_leads_a_coupled_joint_stands_for_it():
    joint = '<body><joint name="{}" axis="0 0 1"/><geom size=".01"/></body>'
    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco><worldbody>{"".join(map(joint.format, ("lead", "follow", "still", "own")))}</worldbody>
      <equality><joint joint1="follow" joint2="lead"/><joint joint1="still"/></equality>
    </mujoco>""")
    assert leading_joints(model, {1, 2, 3}) == {0, 3}
