"""Functions for a notebook: they return what the commands find, and figures of it."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest
from matplotlib.figure import Figure

import tendon_mj
from tendon_mj.errors import RecordingError
from tendon_mj.models import example_recording
from tests.refusals import refusing
from tests.show.rigs import PULLED, TENSION

FRICTION = 0.3


@pytest.fixture(scope="module")
def recording():
    return tendon_mj.read_recording(example_recording())


def test_a_recording_is_short_and_a_table(recording):
    assert len(repr(recording)) < 300
    assert repr(recording.name) in repr(recording)
    table = recording.to_dataframe()
    assert table.index.name == "time_s"
    assert list(table.columns) == list(recording.columns)
    np.testing.assert_array_equal(table.index, recording.time)


def test_plots_of_a_recording_are_figures_with_a_panel_for_each_signal(recording):
    count = len(recording.measured)
    drawn = tendon_mj.plot_recording(example_recording())
    assert isinstance(drawn, Figure)
    assert len(drawn.axes) == 3 * count  # over time, over the drive, and the legend
    fitted = tendon_mj.plot_fit(recording)
    assert len(fitted.axes) == 3 * count
    assert len(fitted.axes[0].lines) == len(drawn.axes[0].lines) + 1


def test_a_sheath_is_drawn_from_its_input_to_its_output_tension():
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=FRICTION)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = TENSION
    for _ in range(200):
        mujoco.mj_step(model, data)
    view = tendon_mj.view_sheath(model, data, "t")
    (axes,) = tendon_mj.plot_sheath(model, data, "t").axes
    values, edges, _ = axes.patches[0].get_data()
    np.testing.assert_array_equal(values, view.tension)
    assert edges[0] == 0.0
    assert axes.get_ylim()[0] == 0.0 < view.tension.max() < axes.get_ylim()[1]


def test_functions_of_a_recording_take_a_description_that_lies_elsewhere(tmp_path):
    table = tmp_path / "pull.csv"
    table.write_bytes(Path(example_recording()).read_bytes())
    description = Path(example_recording()).with_suffix(".toml")
    for function in (tendon_mj.check, tendon_mj.plot_recording, tendon_mj.plot_fit):
        with refusing(RecordingError, "pass `description`"):
            function(table)
        assert function(table, description=description)


def test_a_clip_is_played_in_the_notebook_with_all_its_frames(recording, monkeypatch, tmp_path, gl):
    pytest.importorskip("mediapy")
    shown = []
    monkeypatch.setattr("IPython.display.display", lambda html: shown.append(html.data))
    monkeypatch.setenv("PATH", "")  # without an ffmpeg of the system
    few = replace(recording, time=recording.time[:40], columns=first_rows(recording, 40))
    tendon_mj.show_clip(few, width=320, height=180)
    (html,) = shown
    clip = tmp_path / "clip.mp4"
    clip.write_bytes(base64.b64decode(re.search(r"base64,([^\"]*)", html)[1]))
    frames, _ = imageio_ffmpeg.count_frames_and_secs(str(clip))
    assert frames == round(30 * few.time[-1])
    assert next(imageio_ffmpeg.read_frames(str(clip)))["size"] == (320, 180)


def first_rows(recording, count):
    return {column: values[:count] for column, values in recording.columns.items()}


def test_simulate_returns_a_recording_without_friction_where_there_is_none():
    answer = tendon_mj.simulate("finger", "tap", friction=0.0)
    tension = [answer.columns[f"flexor_{end}_tension_N"] for end in ("input", "output")]
    np.testing.assert_allclose(*tension, rtol=1e-9)


def test_a_sweep_is_a_table_with_a_row_for_each_rollout(tmp_path):
    given = {"motion": "tap", "duration": 0.1, "outputs": ["tip_force.max"]}
    done = tendon_mj.sweep("finger", ["flexor.friction=0.05,0.1"], tmp_path, **given)
    assert len(repr(done).splitlines()) == 1
    table = done.to_dataframe()
    assert list(table["flexor.friction"]) == [0.05, 0.1]
    assert "tip_force.max" in table.columns
