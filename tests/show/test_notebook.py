"""Functions for a notebook: they return what the commands find, and figures of it."""

import base64
import re
import sys
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest
from matplotlib.figure import Figure

import tendon_mj
from tendon_mj.errors import InvalidValueError, MissingPackageError, RecordingError, TendonError
from tendon_mj.lab.diagnosis import SysidResult
from tendon_mj.models import example_recording
from tests.lab.diagnosis.toy import Toy, rig
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


def test_check_finds_no_faults_in_the_example():
    checked = tendon_mj.check(example_recording())
    assert "no faults found" in repr(checked) or all(w.sentence for w in checked.warnings)


def test_functions_of_a_recording_take_a_description_that_lies_elsewhere(tmp_path):
    table = tmp_path / "pull.csv"
    table.write_bytes(Path(example_recording()).read_bytes())
    description = Path(example_recording()).with_suffix(".toml")
    for function in (tendon_mj.check, tendon_mj.plot_recording, tendon_mj.plot_fit):
        with refusing(RecordingError, "pass `description`"):
            function(table)
        assert function(table, description=description)


def test_functions_of_one_recording_say_that_a_list_is_none():
    for function in (tendon_mj.check, tendon_mj.plot_recording, tendon_mj.plot_fit):
        with refusing(RecordingError, "a list is neither a recording nor its path | one at a time"):
            function(["bend.csv", "pull.csv"])


def test_init_writes_a_description_and_keeps_an_existing_one(tmp_path):
    path = tendon_mj.init("finger", tmp_path / "pull.toml")
    assert 'model = "finger"' in path.read_text("utf-8")
    with pytest.raises(InvalidValueError, match=r"pull\.toml exists already"):
        tendon_mj.init("finger", path)


def test_init_names_a_model_from_the_folder_of_the_description(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.xml").write_text(PULLED)
    path = tendon_mj.init("t.xml", "new/pull.toml")
    assert 'model = "../t.xml"' in path.read_text("utf-8")
    assert tendon_mj.init("t.xml").resolve() == tmp_path / "t.toml"


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


def test_without_mediapy_a_clip_says_what_it_needs(recording, monkeypatch):
    monkeypatch.setitem(sys.modules, "mediapy", None)
    with pytest.raises(MissingPackageError, match=r"mediapy.*tendon-mj\[notebook\]"):
        tendon_mj.show_clip(recording)


def first_rows(recording, count):
    return {column: values[:count] for column, values in recording.columns.items()}


def test_results_of_a_diagnosis_are_short():
    train, held_out = rig(1, {"sheath.friction": 0.2, "sheath.constant_friction": 1.0})
    diagnosis = tendon_mj.diagnose(train, held_out, Toy)
    context, selection = diagnosis.search
    results = [*diagnosis.catalogue.values(), diagnosis.located, context, selection]
    for result in [
        *results,
        selection.final,
        SysidResult({"a": (1.0,) * 3}, 1.0, 1.0, {}, 1.0, ""),
    ]:
        lines = repr(result).splitlines()
        assert len(lines) <= 3
        assert max(map(len, lines)) < 1000, type(result)


def test_simulate_returns_a_recording_without_friction_where_there_is_none():
    answer = tendon_mj.simulate("finger", "tap", friction=0.0)
    tension = [answer.columns[f"flexor_{end}_tension_N"] for end in ("input", "output")]
    np.testing.assert_allclose(*tension, rtol=1e-9)


def test_only_the_finger_is_simulated_along_trajectories():
    with refusing(TendonError, "unknown model 'bench'", "'finger'", "tendon-mj view"):
        tendon_mj.simulate("bench", "tap")


def test_a_sweep_is_a_table_with_a_row_for_each_rollout(tmp_path):
    given = {"motion": "tap", "duration": 0.1, "outputs": ["tip_force.max"]}
    done = tendon_mj.sweep("finger", ["flexor.friction=0.05,0.1"], tmp_path, **given)
    assert len(repr(done).splitlines()) == 1
    table = done.to_dataframe()
    assert list(table["flexor.friction"]) == [0.05, 0.1]
    assert "tip_force.max" in table.columns


def test_live_parameters_are_short():
    model = tendon_mj.load_model("finger")
    shown = repr(tendon_mj.Parameters(model, mujoco.MjData(model)))
    assert shown.startswith("Parameters(")
    assert "flexor_sheath" in shown
    assert len(shown) < 200
