"""The frictionless twin behind a model, and the arrows of contact forces over it."""

import dataclasses

import numpy as np
import pytest
from matplotlib.font_manager import findfont
from PIL import ImageFont

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import lasting, press, simulate_finger
from tendon_mj.lab.replay import FrameRecorder
from tendon_mj.models import load_model
from tendon_mj.show import draw_frames
from tendon_mj.show.render import twin as twin_module
from tendon_mj.show.render.arrows import draw_arrow
from tendon_mj.show.render.twin import blend


def test_a_ghost_shows_only_where_the_model_leaves_the_background_free():
    image = np.full((1, 6, 3), 200, np.uint8)
    ghost = np.zeros((1, 6, 3), np.uint8)
    background = np.array([[0.9, 0.9, 0.9, 0.9, 0.9, 0.3]], np.float32)  # the last is in front
    whole = np.array([[0.4, 0.9, 0.9, 0.9, 0.9, 0.3]], np.float32)  # the first is the model's own
    twin = np.array([[0.5, 0.5, 0.5, 0.5, 1.0, 0.5]], np.float32)  # the fifth is free of the ghost
    seen = blend(image, ghost, (whole, twin, background))[0, :, 0]
    assert (seen[2:4] < 150).all()
    assert seen[[0, 1, 4, 5]].tolist() == [200] * 4


def test_a_twin_changes_no_pixel_of_the_model_itself(gl, monkeypatch):
    """So a tendon keeps its tension's colour: what the twin changes was background before.

    Compared in one drawing: Mesa's rasteriser, on a busy machine, may draw the edge of a shadow a
    few pixels apart from one drawing to the next.
    """
    blended = []

    def kept(image, ghost, depths):
        blended.append((image.copy(), blend(image, ghost, depths)))
        return blended[-1][1]

    monkeypatch.setattr(twin_module, "blend", kept)
    model, scene, found = load_model("finger"), load_model("finger", scene=True), []
    for friction in (None, 0.0):
        recorder = FrameRecorder(fps=10)
        simulate_finger(lasting(press(), 1.5), model, friction=friction, recorder=recorder)
        found.append(recorder.frames())
    frames, twin = found
    for _ in draw_frames(scene, frames, width=480, height=270, twin=twin):
        pass
    assert len(blended) == len(frames.poses)
    left = slice(0, 230), slice(0, 316)  # the scene, without legend and panel
    for itself, other in blended[8:14]:  # the two are well apart
        itself, other = itself[left].astype(int), other[left].astype(int)
        changed = np.abs(itself - other).max(axis=2) > 8
        assert 100 < changed.sum() < 0.2 * changed.size
        was = itself[changed]
        assert np.median(was.min(axis=1)) > 200, "white background, or a shadow on it"
        colourful = np.ptp(itself, axis=2) > 60  # tendons
        assert colourful.sum() > 200
        assert not (changed & colourful).any()


def test_a_twin_of_another_length_is_refused():
    recorder = FrameRecorder(fps=10)
    simulate_finger(lasting(press(), 0.5), load_model("finger"), recorder=recorder)
    frames = recorder.frames()
    shorter = dataclasses.replace(frames, poses=frames.poses[:-1])
    with pytest.raises(InvalidValueError, match="the twin has 4 frames"):
        draw_frames(load_model("finger", scene=True), frames, width=480, height=270, twin=shorter)


def test_an_arrow_reaches_from_its_point_to_its_head_and_no_further_aside():
    image = np.full((100, 200, 3), 255, np.uint8)
    font = ImageFont.truetype(findfont("DejaVu Sans"), 12)
    drawn = draw_arrow(image, np.array([40.0, 50.0]), np.array([120.0, 50.0]), "", font, [])
    rows, columns = np.nonzero((drawn != 255).any(axis=2))
    assert 36 <= columns.min() <= 42
    assert 117 <= columns.max() <= 122
    assert np.abs(rows - 50).max() <= 8
    assert (image == 255).all(), "the picture that it was given is not changed"
    nowhere = np.array([np.nan, np.nan])  # behind the camera
    assert (draw_arrow(image, nowhere, nowhere, "1 N", font, []) == image).all()


def test_values_of_two_arrows_do_not_lie_on_each_other():
    image = np.full((200, 300, 3), 255, np.uint8)
    font, written = ImageFont.truetype(findfont("DejaVu Sans"), 12), []
    start, end = np.array([100.0, 60.0]), np.array([100.0, 100.0])
    for aside in (0.0, 4.0):
        away = np.array([aside, 0.0])
        image = draw_arrow(image, start + away, end + away, "1.2 N", font, written)
    one, other = written
    assert other[1] - one[1] > 12.0


@pytest.mark.parametrize(("camera", "upper"), [("view", False), ("finger", True)])
def test_what_the_beads_are_is_said_in_the_emptier_corner(gl, camera, upper):
    """The close camera has the stand in the lower one."""
    recorder = FrameRecorder(fps=10)
    simulate_finger(lasting(press(), 0.5), load_model("finger"), recorder=recorder)
    scene, frames = load_model("finger", scene=True), recorder.frames()
    first = next(draw_frames(scene, frames, width=960, height=540, camera=camera))
    dark = (first[:30, :300].max(axis=2) < 90).sum()
    assert (dark > 100) == upper
