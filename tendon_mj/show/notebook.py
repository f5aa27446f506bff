"""Functions for a notebook: commands that return objects, and plots that return figures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
from matplotlib.figure import Figure

from tendon_mj.attach import view_sheath
from tendon_mj.errors import InvalidValueError, MissingPackageError
from tendon_mj.lab import finger
from tendon_mj.lab.data_check import Checked, check_recording
from tendon_mj.lab.diagnosis import Diagnosis
from tendon_mj.lab.fleet import FleetResult, find_rigs, run_fleet
from tendon_mj.lab.frames import FrameRecorder
from tendon_mj.lab.recordings import GivenRecording, Recording, read_given
from tendon_mj.lab.replay import format_template, load_recorded, replay_recording
from tendon_mj.lab.sweep import Sweep, SweepResult, motion_recording, run_sweep
from tendon_mj.models import load_model, model_names, model_path
from tendon_mj.show import style
from tendon_mj.show.figures.simulations import before_after_figure, replay_figure
from tendon_mj.show.render.clip import check_size, draw_frames
from tendon_mj.show.report.pictures import misfit_figure
from tendon_mj.show.report.text import most_telling
from tendon_mj.whole_file import whole_file


def init(model: str, path: str | Path | None = None) -> Path:
    """Write a description of recordings of a model, to be filled in; returns its path.

    Args:
        model: name of a model of the package, or path of an MJCF file, which the description names
            from its own folder.
        path: TOML file to write; default: one of the model's name in the current folder.

    Raises:
        UnknownNameError: no such model.
        InvalidValueError: the file exists already.
    """
    compiled = load_model(model)
    path = Path(f"{model_path(model).stem}.toml" if path is None else path)
    if path.exists():
        raise InvalidValueError(f"{path} exists already; give another path, or remove it first")
    if model not in model_names():
        model = Path(os.path.relpath(model, path.parent)).as_posix()
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as made:
        made.write_text(format_template(compiled, model), encoding="utf-8", newline="\n")
    return path


def check(
    recording: GivenRecording,
    model: mujoco.MjModel | None = None,
    *,
    description: str | Path | None = None,
    settle: float | None = None,
) -> Checked:
    """Simulate a recording at the values that its description states, and warn of its faults.

    Args:
        recording: recording, or the path of its table or TOML file.
        model: model in place of the one that the recording names; not changed.
        description: path of its TOML file, where it does not lie beside the table.
        settle: time before the first sample [s]; default: as the recording states.

    Raises:
        RecordingError: a recording that cannot be read or simulated.
    """
    return check_recording(read_given(recording, description), model, settle=settle)


def simulate(
    model: str = "finger", motion: str = "curl", *, friction: float | None = None
) -> Recording:
    """Let the finger follow joint angles or tendon tensions; returns every sensor's series.

    Args:
        model: "finger" or "finger_spring".
        motion: "curl", "tap", "press", "hold", or the path of a CSV file with time_s and either
            joint angles or tensions.
        friction: friction coefficient of every sheath [-]; default: as in the model.

    Raises:
        TendonError: another model, no such motion, or one that the finger cannot follow.
    """
    finger.check_finger(model)
    trajectory = finger.find_trajectory(motion)
    return finger.simulate_finger(trajectory, load_model(model), name=model, friction=friction)


def sweep(
    model: str,
    parameters: Sequence[str],
    folder: str | Path,
    *,
    motion: str | None = None,
    duration: float | None = None,
    draws: int = 0,
    seed: int = 0,
    outputs: Sequence[str] = (),
    again: bool = False,
) -> SweepResult:
    """Simulate a model with many values of its parameters; an interrupted sweep is continued.

    It runs on all cores, in processes that read the caller's script again: put the call under
    `if __name__ == "__main__":`.

    Args:
        model: name of a model of the package, or path of an MJCF file.
        parameters: such as "flexor.friction=0.05:0.3:6"; see `tendon-mj sweep --help`.
        folder: folder for the table of results, which is kept.
        motion: name of a motion of the finger, or path of a CSV file; default: the model's own.
        duration: duration of the motion [s]; default: its own.
        draws: number of random draws of the ranges without a grid.
        seed: seed of the draws.
        outputs: such as "tip_force.max"; default: all.
        again: whether to start again in a folder that holds another sweep.

    Raises:
        UnknownNameError: no such model, motion, parameter or output.
        InvalidValueError: a range or folder that cannot be used.
        WorkerError: processes that ended, as where a script calls it outside of that.
    """
    compiled = load_model(model)
    driven = motion_recording(model_path(model).stem, compiled, motion, duration)
    plan = Sweep(compiled, driven, parameters, draws=draws, seed=seed, outputs=outputs)
    return run_sweep(plan, Path(folder), again=again)


def fleet(folder: str | Path, out: str | Path) -> FleetResult:
    """Find which rigs of a fleet changed, and which differ from the others.

    Args:
        folder: folder with a folder of dated recordings for each rig.
        out: folder for results of each rig, which the next call does not compute again.

    Raises:
        RecordingError: the folder is not a fleet.
    """
    return run_fleet(find_rigs(Path(folder), Path(out)), Path(out))


def plot_recording(recording: GivenRecording, *, description: str | Path | None = None) -> Figure:
    """Measured columns of a recording over time, and over its drive.

    Args:
        recording: recording, or the path of its table or TOML file.
        description: path of its TOML file, where it does not lie beside the table.

    Raises:
        RecordingError: a recording that cannot be read, or has no measured column.
    """
    return replay_figure(read_given(recording, description), {})


def plot_fit(
    recording: GivenRecording | Diagnosis,
    simulated: Mapping[str, Recording] | Recording | mujoco.MjModel | None = None,
    *,
    description: str | Path | None = None,
) -> Figure:
    """Measured and simulated columns, with their rms errors.

    Args:
        recording: recording, or the path of its table or TOML file; or a diagnosis, of which the
            recording with the largest error is drawn before and after it, with the residuals.
        simulated: label → simulation of the recording, one simulation, or a model to simulate it
            on; default: the model that the recording names.
        description: path of its TOML file, where it does not lie beside the table.

    Raises:
        RecordingError: a recording that cannot be read or simulated, or has no measured column.
    """
    if isinstance(recording, Diagnosis):
        shown, _ = most_telling(recording.simulate())
        after = shown.after if recording.changed else None
        return before_after_figure(shown.measured, shown.before, after)
    recording = read_given(recording, description)
    if simulated is None or isinstance(simulated, mujoco.MjModel):
        simulated = replay_recording(recording, simulated)
    if isinstance(simulated, Recording):
        simulated = {"simulated": simulated}
    return replay_figure(recording, simulated)


def plot_misfit(diagnosis: Diagnosis) -> Figure:
    """Share of the misfit beyond noise in each regime of the motion, before and after."""
    return misfit_figure(diagnosis.located, diagnosis.remaining if diagnosis.changed else None)


def plot_sheath(model: mujoco.MjModel, data: mujoco.MjData, sheath: str) -> Figure:
    """Tension [N] along a tendon in its sheath, from its input end to its output end [m].

    Args:
        model: model with sheaths.
        data: its data, after a step or `mj_forward`.
        sheath: name of the sheath or of its tendon.

    Raises:
        UnknownNameError: no such sheath or tendon.
    """
    view = view_sheath(model, data, sheath)
    along = np.concatenate([[0.0], view.lengths.cumsum()])
    unit = style.drawn_unit("along_m", along)
    along *= unit.factor
    with style.print_style():
        figure = style.new_figure(6.5, 2.8)
        axes = figure.subplots()
        axes.stairs(view.tension, along, baseline=None, color=style.BLUE, linewidth=2.0)
        slipping = view.slip != 0.0
        between = 0.5 * (view.tension[:-1] + view.tension[1:])
        for chosen, colour, label in (
            (slipping, style.VERMILLION, "guide that slips"),
            (~slipping, style.GREY, "guide that sticks"),
        ):
            if chosen.any():
                axes.plot(along[1:-1][chosen], between[chosen], "o", color=colour, label=label)
        axes.set(
            title=f"{view.name} at {data.time:.4g} s",
            xlabel=f"from the input end [{unit.symbol}]",
            ylabel="tension [N]",
        )
        axes.set_ylim(0.0, max(1.15 * view.tension.max(), 1e-6))  # a slack tendon has none
        style.legend_below(figure, axes, columns=2)
    return figure


def show_clip(
    recording: GivenRecording,
    model: mujoco.MjModel | None = None,
    *,
    description: str | Path | None = None,
    width: int = 960,
    height: int = 540,
    camera: str | None = None,
) -> None:
    """Simulate a recording and play it in a notebook; see `render_clip` for the picture.

    Args:
        recording: recording, or the path of its table or TOML file.
        model: model in place of the one that the recording names; not changed.
        description: path of its TOML file, where it does not lie beside the table.
        width, height: of the clip [pixels], even numbers.
        camera: name of one of the model's; default: its first, or a view of the whole model.

    Raises:
        MissingPackageError: mediapy is not installed.
        EngineError: no OpenGL is available; the message says what to install or set.
        RecordingError: a recording that cannot be read or simulated.
    """
    try:
        mediapy = import_module("mediapy")
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"show_clip needs {error.name}, which is not installed: "
            "pip install 'tendon-mj[notebook]'",
            name=error.name,
        ) from None
    check_size(width, height)
    recording, recorder = read_given(recording, description), FrameRecorder()
    if model is None:
        model = load_recorded(recording)
    replay_recording(recording, model, recorder=recorder)
    frames = recorder.frames()
    images = draw_frames(model, frames, width=width, height=height, camera=camera)
    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())  # the system need not have one
    mediapy.show_video(images, fps=frames.fps)
