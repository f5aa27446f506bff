import subprocess

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest
from matplotlib.colors import Normalize
from scipy.ndimage import minimum_filter
from scipy.spatial import KDTree

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.finger import simulate_finger, tap
from tendon_mj.lab.replay import Cable, FrameRecorder, default_motion, record_frames
from tendon_mj.models import Bench, build_bench, load_model
from tendon_mj.plugin import segment_tensions, sheaths
from tendon_mj.show import (
    Offscreen,
    add_cable,
    draw_frames,
    find_camera,
    render_clip,
    without_tendons,
)
from tendon_mj.show.render.cable import COLOURS, cable_radius
from tendon_mj.show.render.offscreen import project


@pytest.fixture(scope="module")
def model():
    return build_bench(Bench(guides=6)).compile()


def still(model):
    """A frame at rest."""
    return record_frames(model, lambda time: [0.0], duration=0.1, fps=10)


def frames_of(path, width, height):
    """(k, height, width, 3) frames, and what ffmpeg says of the file."""
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run([ffmpeg, "-i", str(path), *raw], capture_output=True, check=True)
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)
    return frames, done.stderr.decode()


def test_a_clip_has_its_size_its_frames_and_moves(gl, model, tmp_path):
    told = []

    def progress(what, done, total):
        told.append((what, done, total))

    recorded = record_frames(
        model, default_motion("bench", model), duration=0.8, fps=10, progress=progress
    )
    path = tmp_path / "new" / "bench.mp4"
    render_clip(model, recorded, path, width=480, height=270, progress=progress)
    frames, said = frames_of(path, 480, 270)
    assert frames.shape == (8, 270, 480, 3)
    assert "480x270" in said
    assert "yuv420p(tv, bt709" in said, "which all browsers play, and in which matrix"
    assert "10 fps" in said
    assert told[-1] == ("draw", 8, 8)
    assert ("simulate", 8, 8) in told
    scene, strip = np.split(frames[[0, 7]].astype(float), [336], axis=2)
    assert np.abs(scene[1] - scene[0]).max() > 30.0, "the tendon changes its colour"
    assert np.abs(strip[1] - strip[0]).max() > 30.0, "the cursor moves"


def test_a_model_without_a_sheath_has_no_strip(gl, tmp_path):
    ball = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
    )
    recorded = record_frames(ball, np.zeros((1, 0)), duration=0.2, fps=10)
    path = render_clip(ball, recorded, tmp_path / "b.mp4", width=128, height=96)
    frames, _ = frames_of(path, 128, 96)
    assert frames.shape == (2, 96, 128, 3)
    assert frames[0, :, -20:].min() > 240, "white to the edge"


@pytest.mark.parametrize("size", [{"width": 481}, {"height": 20}])
def test_a_size_that_no_video_has_is_refused(model, tmp_path, size):
    with pytest.raises(InvalidValueError, match="must be even"):
        render_clip(model, still(model), tmp_path / "x.mp4", **size)


def test_an_unknown_camera_is_answered_with_those_there_are(model, tmp_path):
    with pytest.raises(UnknownNameError, match="unknown camera 'front'"):
        render_clip(model, still(model), tmp_path / "x.mp4", camera="front")


def test_frames_of_another_model_are_refused(model, tmp_path):
    other = load_model("joint")
    with pytest.raises(InvalidValueError, match="of another model"):
        render_clip(other, still(model), tmp_path / "x.mp4")


def test_a_clip_of_a_replay_is_drawn_on_the_scene_that_the_bare_model_lacks(gl, tmp_path):
    recorder = FrameRecorder(fps=10)
    simulate_finger(tap(), load_model("finger"), recorder=recorder)
    path = tmp_path / "tap.mp4"
    render_clip(load_model("finger", scene=True), recorder.frames(), path, width=480, height=270)
    frames, _ = frames_of(path, 480, 270)
    assert len(frames) == 30
    assert np.abs(frames[5].astype(float) - frames[0]).max() > 30.0


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
