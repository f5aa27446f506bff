"""Floor, light and camera of a model that has none: seen, and without effect on it."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive
from tendon_mj.lab.frames import FrameRecorder
from tendon_mj.models import model_digest
from tendon_mj.show.render.offscreen import project
from tendon_mj.show.render.surroundings import add_floor, first_camera, floor, framing, to_show
from tests.rigs import compiled, rope
from tests.show.rigs import CAMERA, PULLED

BARE = PULLED.replace(CAMERA, "")
SIZE = 400, 348  # a picture as narrow as a clip's


def turned(euler):
    """A model whose world is turned [deg]."""
    frame = f'<worldbody><frame euler="{" ".join(map(str, euler))}">'
    text = BARE.replace("<worldbody>", frame).replace("</worldbody>", "</frame></worldbody>")
    return mujoco.MjModel.from_xml_string(text)


@pytest.mark.parametrize("euler", [(0, 0, 0), (90, 0, 0), (0, 90, 0), (20, 30, 40), (0, 0, 130)])
def test_a_tendon_is_seen_along_its_length_however_it_lies(euler):
    model = turned(euler)
    scene, data = mujoco.MjvScene(model, 100), mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, framing(model), 7, scene)
    seen = project(scene, data.wrap_xpos.reshape(-1, 3)[: data.ten_wrapnum[0]], *SIZE)
    assert (seen > 0.0).all()
    assert (seen < SIZE).all()
    length = np.linalg.norm(np.diff(seen, axis=0), axis=1).sum()
    assert length > 0.5 * min(SIZE), "neither end on nor from afar"


@pytest.mark.parametrize(("axis", "azimuth"), [("0 1 0", 90.0), ("1 0 0", 0.0)])
def test_a_straight_tendon_is_looked_at_from_where_its_motion_is_seen(axis, azimuth):
    """It lies in every plane along it, and says nothing about the one in which the joint bends."""
    text = rope(
        "a 0 0 -.4; b 0 0 -.01",
        "c 0 0 .1; d 0 0 .2",
        joint=f'axis="{axis}"',
        geom='type="capsule" fromto="0 0 0 0 0 .2" size=".01"',
    )
    poses = np.radians(np.linspace(0.0, 40.0, 5))[:, None]
    seen = framing(compiled(text), poses)
    assert abs((seen.azimuth - azimuth + 90.0) % 180.0 - 90.0) < 1.0


@pytest.mark.parametrize("axis", ["0 1 0", "0 1 1"])
def test_a_view_across_the_tendons_stays_where_another_shows_little_more(axis):
    text = rope(
        "a -.1 0 -.4; b .1 0 -.01",
        "c .1 0 .1; d 0 0 .2",
        joint=f'axis="{axis}"',
        geom='type="capsule" fromto="0 0 0 0 0 .2" size=".01"',
    )
    model, poses = compiled(text), np.radians(np.linspace(0.0, 40.0, 5))[:, None]
    assert framing(model, poses).azimuth == pytest.approx(framing(model).azimuth)


def test_a_camera_that_hardly_shows_the_tendons_is_passed_over():
    far = '<camera name="far" pos="0.5 -90 0.1" xyaxes="1 0 0 0 0 1"/>'
    behind = '<camera name="behind" pos="0.5 1.2 0.1" xyaxes="1 0 0 0 0 1"/>'
    for cameras, first in ((far + behind + CAMERA, 2), (CAMERA + far, 0), (far + behind, -1)):
        assert (
            first_camera(mujoco.MjModel.from_xml_string(PULLED.replace(CAMERA, cameras))) == first
        )


def test_what_is_added_lies_below_the_model_and_leaves_it_as_it_is():
    model = mujoco.MjModel.from_xml_string(BARE)
    before, data = model_digest(model), mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    shown, ground, scene = to_show(model), floor(model), mujoco.MjvScene(model, 100)
    add_floor(scene, ground)
    framing(model)
    assert ground.middle[2] < data.geom_xpos[:, 2].min()
    assert scene.ngeom == 1
    assert model_digest(model) == before
    assert shown.ngeom == model.ngeom, "nothing that could collide"
    assert shown.vis.headlight.ambient[0] > model.vis.headlight.ambient[0]


def test_a_model_s_own_floor_and_light_are_kept():
    own = '<worldbody><geom type="plane" size="1 1 1"/><light pos="0 0 3"/>'
    model = mujoco.MjModel.from_xml_string(BARE.replace("<worldbody>", own, 1))
    assert floor(model) is None
    shown = to_show(model)
    assert np.array_equal(shown.vis.headlight.ambient, model.vis.headlight.ambient)


def test_a_camera_on_a_moving_body_is_not_chosen():
    sights = '<camera name="{}" pos=".05 -.35 .1" xyaxes="1 0 0 0 0 1"/>'
    text = rope(
        "a 0 0 0; b 0 0 .1",
        "c .1 0 .2",
        joint='axis="0 1 0"',
        geom='size=".02"',
        world=sights.format("still"),
    )
    assert first_camera(compiled(text)) == 0
    moving = text.replace(sights.format("still"), "").replace(
        "<joint", sights.format("m") + "<joint", 1
    )
    assert first_camera(compiled(moving)) == -1


def test_cables_without_a_path_are_neither_framed_nor_drawn():
    text = """<mujoco><worldbody><body><joint name="j" axis="0 1 0" armature="1e-3"/>
     <geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01"/></body></worldbody>
     <actuator><position name="m" joint="j" kp="1"/></actuator></mujoco>"""
    spec = mujoco.MjSpec.from_string(text)
    cables = {"radius": 0.01, "bend": 2.0, "friction": 0.2, "pretension": 5.0, "length": 0.5}
    model = add_cable_drive(spec, "m", motor=True, axial_stiffness=500.0, **cables).compile()
    seen, bare = framing(model), framing(mujoco.MjModel.from_xml_string(text))
    np.testing.assert_allclose(seen.lookat, bare.lookat, atol=1e-9)
    assert seen.distance == pytest.approx(bare.distance)
    recorder = FrameRecorder()
    recorder.keep(model, mujoco.MjData(model), [0.1])
    assert len(recorder.frames().cables) == 2
    assert not recorder.frames().drawn
