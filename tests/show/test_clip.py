"""Clips: what they show and in which colours, the frictionless twin, and arrows of forces."""

import dataclasses
import subprocess

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest
from matplotlib.colors import Normalize
from matplotlib.font_manager import findfont
from PIL import ImageFont
from scipy.ndimage import minimum_filter
from scipy.spatial import KDTree

from tendon_mj import add_friction
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import lasting, press, simulate_finger
from tendon_mj.lab.frames import Cable, FrameRecorder
from tendon_mj.lab.motion import default_motion, record_frames
from tendon_mj.models import Bench, build_bench, load_model
from tendon_mj.plugin import segment_tensions, sheaths
from tendon_mj.show import Offscreen, draw_frames, find_camera, render_clip
from tendon_mj.show.render import offscreen as scene_module
from tendon_mj.show.render.clip import draw_arrow
from tendon_mj.show.render.offscreen import (
    COLOURS,
    add_cable,
    blend,
    cable_radius,
    project,
    without_tendons,
)
from tests.rigs import rope


@pytest.fixture(scope="module")
def model():
    return build_bench(Bench(guides=6)).compile()


def still(model):
    """A frame at rest."""
    return record_frames(model, lambda time: [0.0], duration=0.1, fps=10)


def pressing(seconds, friction=None):
    """Frames of the finger as it presses."""
    recorder = FrameRecorder(fps=10)
    trajectory = lasting(press(), seconds)
    simulate_finger(trajectory, load_model("finger"), friction=friction, recorder=recorder)
    return recorder.frames()


def frames_of(path, width, height):
    """(k, height, width, 3) frames, and what ffmpeg says of the file."""
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run([ffmpeg, "-i", str(path), *raw], capture_output=True, check=True)
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)
    return frames, done.stderr.decode()


def test_a_clip_has_its_size_its_frames_and_moves(gl, model, tmp_path):
    steps = []

    def progress(*step):
        steps.append(step)

    recorded = record_frames(
        model, default_motion("bench", model), duration=0.8, fps=10, progress=progress
    )
    path = tmp_path / "new" / "bench.mp4"
    render_clip(model, recorded, path, width=480, height=270, progress=progress)
    frames, output = frames_of(path, 480, 270)
    assert frames.shape == (8, 270, 480, 3)
    assert "480x270" in output
    assert "yuv420p(tv, bt709" in output, "which all browsers play, and in which matrix"
    assert "10 fps" in output
    assert steps[-1] == ("draw", 8, 8)
    assert ("simulate", 8, 8) in steps
    scene, strip = np.split(frames[[0, 7]].astype(float), [336], axis=2)
    assert np.abs(scene[1] - scene[0]).max() > 30.0, "the tendon changes its colour"
    assert np.abs(strip[1] - strip[0]).max() > 30.0, "the cursor moves"


def test_frames_of_another_model_or_another_length_are_refused(model, tmp_path):
    frames = still(model)
    with pytest.raises(InvalidValueError, match="of another model"):
        render_clip(load_model("joint"), frames, tmp_path / "x.mp4")
    shorter = dataclasses.replace(frames, poses=frames.poses[:0])
    with pytest.raises(InvalidValueError, match="the twin has 0 frames"):
        draw_frames(model, frames, width=480, height=270, twin=shorter)


@pytest.mark.parametrize("height", [0.0, 0.3])
@pytest.mark.parametrize(
    ("words", "input_end"), [("a b drum@top d", "first"), ("d drum@top b a", "last")]
)
def test_a_tendon_is_drawn_from_its_input_to_its_output_beside_a_geom(height, words, input_end):
    """It wraps around the geom, or passes above without touching it."""
    text = rope(
        f"a -.6 0 {height}; b -.3 0 {height}; top 0 0 .2",
        "d",
        words,
        body=f'pos=".3 0 {height}"',
        world='<geom name="drum" type="cylinder" size=".05 .1" euler="90 0 0"/>',
        joint='type="slide"',
    )
    spec = mujoco.MjSpec.from_string(text)
    add_friction(spec, "t", friction=0.1, arc_guides=1, input_end=input_end)
    model = spec.compile()
    data, scene = mujoco.MjData(model), mujoco.MjvScene(model, 100)
    mujoco.mj_forward(model, data)
    (cable,) = record_frames(model, lambda time: [5.0], duration=0.1, fps=10).cables.values()
    for drawn, site in zip(cable.points[0, [0, -1]], ("a", "d"), strict=True):
        np.testing.assert_allclose(drawn, data.site(site).xpos)
    length = np.linalg.norm(np.diff(cable.points[0], axis=0), axis=1).sum()
    assert length == pytest.approx(data.ten_length[0], rel=0.02), "no stretch of it twice"
    add_cable(scene, cable.points[0], cable.tensions[0], Normalize(0.0, 10.0), 0.01)
    sphere = mujoco.mjtGeom.mjGEOM_SPHERE
    beads = np.array([geom.pos for geom in scene.geoms[: scene.ngeom] if geom.type == sphere])
    away = np.linalg.norm(beads[:, None] - cable.points[0, [0, -1]], axis=2)
    assert away.min() > 0.1, "its ends are no guides"


@pytest.mark.parametrize(
    ("name", "camera"),
    [
        ("finger", "view"),
        ("finger", "finger"),
        ("joint", "view"),
        ("joint", "spool"),
        ("joint", "hinge"),
        ("bench", "view"),
    ],
)
def test_the_colour_of_a_segment_is_that_of_the_bar(gl, name, camera):
    """At 20 tensions, within 4 of 255, also in conduits, phalanges, light and shadow."""
    model = load_model(name, scene=True)
    data, scale, size = mujoco.MjData(model), Normalize(0.0, 40.0), (960, 720)
    mujoco.mj_forward(model, data)
    paths = {name: segment_tensions(model, data, name)[0] for name in sheaths(model)}
    cables = {name: Cable(points[None], np.empty((1, 0))) for name, points in paths.items()}
    thick = cable_radius(model, cables)
    compared = 0
    with Offscreen(without_tendons(model), *size) as offscreen:
        for tension in np.linspace(1.0, 39.0, 20):

            def add(scene, tension=tension):
                for points in paths.values():
                    add_cable(scene, points, np.full(len(points) - 1, tension), scale, thick)

            image = offscreen.draw(data, find_camera(model, camera), add)
            for points in paths.values():
                seen = project(offscreen.scene, 0.5 * (points[1:] + points[:-1]), *size)
                ends = project(offscreen.scene, points, *size)
                long = np.linalg.norm(np.diff(ends, axis=0), axis=1) > 24.0  # of more than beads
                inside = ((seen > 2) & (seen < np.array(size) - 2)).all(axis=1) & long
                columns, rows = seen[inside].astype(int).T
                bar = 255.0 * np.array(COLOURS(scale(tension))[:3])
                expected = np.tile(bar, (len(rows), 1))
                np.testing.assert_allclose(image[rows, columns], expected, atol=4.0)
                compared += len(rows)
    assert compared >= 40


@pytest.mark.parametrize("name", ["finger", "joint"])
def test_a_tension_is_read_off_a_clip_to_a_step_of_the_bar(gl, name, tmp_path):
    """The median within one of 256 steps, 19 of 20 within three."""
    model, size = load_model(name, scene=True), (1280, 720)
    drive = default_motion(name, model)
    recorded = record_frames(model, drive, duration=0.8, fps=5)
    width, height = size
    drawn = np.stack(list(draw_frames(model, recorded, width=width, height=height)))
    decoded, _ = frames_of(
        render_clip(model, recorded, tmp_path / "c.mp4", width=width, height=height), *size
    )
    bar = KDTree(255.0 * np.array(COLOURS(np.arange(256)))[:, :3])
    away, step = bar.query(drawn[:, :, :800].reshape(-1, 3))  # the scene, without the panel
    of_cable = minimum_filter(away.reshape(-1, height, 800) < 1.0, size=(1, 3, 3))
    assert of_cable.sum() > 1000, "pixels inside a cable"
    _, read = bar.query(decoded[:, :, :800][of_cable])
    error = np.abs(read - step.reshape(of_cable.shape)[of_cable])
    assert np.median(error) <= 1.0
    assert np.quantile(error, 0.95) <= 3.0


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

    monkeypatch.setattr(scene_module, "blend", kept)
    scene, frames, twin = load_model("finger", scene=True), pressing(1.5), pressing(1.5, 0.0)
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
