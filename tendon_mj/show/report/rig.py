"""Picture of a rig at the highest tension of a recording, its tendons coloured by tension."""

from __future__ import annotations

import warnings

import mujoco
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import BeforeAfter
from tendon_mj.lab.frames import POSE, FrameRecorder
from tendon_mj.lab.replay import load_recorded, replay_recording
from tendon_mj.show import style
from tendon_mj.show.render import offscreen

_FPS, _FRAMES = 30.0, 500.0  # at most, among which the highest tension is found [1/s], [-]
_SIZE = 1280, 960  # of the picture before its empty margins are cut off [pixels]
_MARGIN = 12  # of them that is kept [pixels]
_WHITE = 255


def rig_figure(shown: BeforeAfter) -> Figure | None:
    """The final model when a tension of the recording is highest.

    None if it cannot be drawn: without OpenGL, a tendon in a sheath that has a path, or a model
    that MuJoCo simulates.
    """
    recording, values = shown.measured, shown.after.known
    start, end = recording.time[[0, -1]]
    recorder = FrameRecorder(min(_FPS, _FRAMES / float(end - start)))
    try:
        model = load_recorded(recording)
        with warnings.catch_warnings():  # the simulations that count warned already
            warnings.simplefilter("ignore", RuntimeWarning)
            replay_recording(
                recording, model, parameters=values, described=False, recorder=recorder
            )
        frames = recorder.frames()
        if not frames.drawn:
            return None
        tensions = np.hstack([cable.tensions for cable in frames.drawn.values()])
        peak = int(np.nan_to_num(tensions).max(axis=1).argmax())
        bare = offscreen.without_tendons(model)
        data = mujoco.MjData(bare)
        mujoco.mj_setState(bare, data, frames.poses[peak], POSE)
        mujoco.mj_fwdPosition(bare, data)
        scale = offscreen.colour_limits(frames.drawn)
        radius = offscreen.cable_radius(model, frames.drawn)
        cables = offscreen.cables_at(frames.drawn, peak, scale, radius)
        view = offscreen.find_camera(model, None, data.qpos[None])
        with offscreen.Offscreen(bare, *_SIZE, ground=False) as buffer:
            image = _without_margins(buffer.draw(data, view, cables))
    except TendonError:
        return None
    wide = image.shape[1] / image.shape[0]
    with style.print_style():
        figure = style.new_figure(min(5.0, 1.0 + 2.1 * wide), min(2.4, 0.3 + 4.0 / wide))
        axes = figure.subplots()
        drawn = np.any(image < _WHITE, axis=2, keepdims=True)  # the page shows through the rest
        axes.imshow(np.concatenate([image, _WHITE * drawn.astype(np.uint8)], axis=2))
        axes.set_axis_off()
        axes.set_title(f"{recording.name} at {start + frames.time[peak]:.3g} s", parse_math=False)
        colours = ScalarMappable(scale, offscreen.COLOURS)
        bar = figure.colorbar(colours, ax=axes, fraction=0.03, pad=0.01)
        bar.set_label("tension [N]")
        figure.patch.set_alpha(0.0)
    return figure


def _without_margins(image: offscreen.Image) -> offscreen.Image:
    """The part of a picture that is not white."""
    rows, columns, _ = np.nonzero(image < _WHITE)
    if not rows.size:
        return image
    top, left = max(rows.min() - _MARGIN, 0), max(columns.min() - _MARGIN, 0)
    return image[top : rows.max() + _MARGIN, left : columns.max() + _MARGIN]
