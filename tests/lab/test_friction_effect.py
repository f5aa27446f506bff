"""What a clip says of friction: the tendons that lose most, and a sentence of one moment."""

import dataclasses
import re

import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive, add_friction
from tendon_mj.errors import UnknownNameError
from tendon_mj.lab.friction_effect import (
    free_joints,
    friction_sentence,
    most_first,
    sheathed_tendons,
)
from tendon_mj.lab.motion import frictionless, record_frames
from tests.refusals import refusing

TENDON = (
    """<spatial name="{0}"><site site="{0}a"/><site site="{0}b"/><site site="{0}c"/></spatial>"""
)
FINGER = """<site name="{0}a" pos="0 {1} 0"/><site name="{0}b" pos=".1 {1} .1"/>
  <body pos=".2 {1} 0"><joint name="{0}_joint" axis="0 1 0" stiffness=".5" damping=".1"/>
    <geom size=".02" pos=".1 0 0" contype="0" conaffinity="0"/><site name="{0}c" pos=".03 0 .03"/>
  </body>"""


def fingers(**frictions):
    """Fingers on springs, each pulled with 20 N by a motor over a guide with a friction."""
    names = list(frictions)
    spec = mujoco.MjSpec.from_string(
        f"""<mujoco><option gravity="0 0 0"/>
        <worldbody>{"".join(FINGER.format(n, k) for k, n in enumerate(names))}</worldbody>
        <tendon>{"".join(map(TENDON.format, names))}</tendon>
        <actuator>{"".join(f'<motor tendon="{n}" ctrlrange="-50 0"/>' for n in names)}</actuator>
        </mujoco>"""
    )
    for name, friction in frictions.items():
        add_friction(spec, [name], friction=friction)
    model = spec.compile()

    def record(parameters=None):
        pull = np.full(len(names), -20.0)
        return record_frames(model, lambda _: pull, duration=1.0, fps=10, parameters=parameters)

    return model, record(), record(frictionless(model))


def test_those_that_lose_most_come_first_and_others_can_be_left_out():
    model, frames, _ = fingers(index=0.1, middle=0.4, ring=0.2)
    order = [name.removesuffix("_sheath") for name in most_first(model, frames).cables]
    assert order == ["middle", "ring", "index"]
    kept = most_first(model, frames, sheathed_tendons(model, "[ir]*")).cables
    assert list(kept) == ["ring_sheath", "index_sheath"]
    with refusing(UnknownNameError, "thumb", "index"):
        sheathed_tendons(model, "thumb")


def test_the_sentence_is_of_the_joint_that_lags_and_of_its_tendon():
    model, frames, twin = fingers(index=0.1, middle=0.4)
    sentence = friction_sentence(model, most_first(model, frames), twin)
    numbers = re.findall(r"\d[\d.]*\b", sentence)
    when, arrives, pulled, lag, there, free = map(float, numbers)
    k = round(when * frames.fps)
    path = frames.cables["middle_sheath"].tensions[k]
    assert [pulled, arrives] == pytest.approx([path[0], path[-1]], rel=5e-3)
    angles = np.degrees([frames.poses[k, 1], twin.poses[k, 1]])
    assert [there, free] == pytest.approx(np.abs(angles), abs=0.06)
    assert lag == pytest.approx(free - there, rel=0.06)
    assert "output of middle, and middle_joint turns" in sentence
    assert "less than without friction" in sentence


@pytest.mark.parametrize(
    ("share", "degrees", "lags"),
    [(1.0, 0.04, False), (1.0, 0.06, True), (0.4, 5.0, False), (0.6, 5.0, True)],
)
def test_a_joint_lags_by_what_is_written_if_friction_takes_half_of_its_most(share, degrees, lags):
    """Of one frame, in which friction takes a share of what it takes in the others."""
    model, frames, _ = fingers(index=0.4)
    cable = frames.cables["index_sheath"]
    tensions, poses = np.tile(cable.tensions[-1], (len(cable.tensions), 1)), frames.poses.copy()
    tensions[4] *= share
    poses[4] += np.radians(degrees) * (np.arange(poses.shape[1]) == model.jnt_qposadr[0])
    cables = {"index_sheath": dataclasses.replace(cable, tensions=tensions)}
    still = dataclasses.replace(
        frames, cables=cables, poses=np.tile(frames.poses[4], (len(poses), 1))
    )
    moved = dataclasses.replace(
        still, poses=np.where(np.arange(len(poses))[:, None] == 4, poses, still.poses)
    )
    assert ("index_joint" in friction_sentence(model, still, moved)) == lags


@pytest.mark.parametrize(
    ("ends", "says"),
    [
        ((40.0, 10.0), "10 of 40 N arrive at the output"),
        ((10.0, 40.0), "10 of 40 N arrive at the input"),
        ((-46.1, -2.25), "2.25 of 46.1 N arrive at the output"),  # of a cable that pulls back
        ((41.8, -0.65), "none of 41.8 N arrive at the output"),
    ],
)
def test_what_arrives_is_a_share_of_the_larger_tension_whichever_way_it_pulls(ends, says):
    model, frames, _ = fingers(index=0.4)
    cable = frames.cables["index_sheath"]
    tensions = np.tile(np.linspace(*ends, cable.tensions.shape[1]), (len(cable.tensions), 1))
    cables = {"index_sheath": dataclasses.replace(cable, tensions=tensions)}
    assert says in friction_sentence(model, dataclasses.replace(frames, cables=cables), None)


def test_a_joint_that_a_cable_turns_which_is_not_drawn_is_not_moved_directly():
    spec = mujoco.MjSpec.from_string(
        """<mujoco><worldbody><body><joint name="turned"/><geom size=".1"/>
        <body><joint name="direct"/><geom size=".1"/></body></body></worldbody>
        <actuator><motor name="a" joint="turned"/><motor joint="direct"/></actuator></mujoco>"""
    )
    add_cable_drive(spec, "a", radius=0.01, bend=3.0, friction=0.1)
    assert free_joints(spec.compile(), mujoco.mjtJoint.mjJNT_HINGE) == [0]
