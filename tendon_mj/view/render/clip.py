"""Clip of recorded frames, drawn offscreen, the tendons coloured by the tension along them."""

from __future__ import annotations

from pathlib import Path

import imageio_ffmpeg
import mediapy
import mujoco
import numpy as np
from matplotlib.colors import Normalize
from matplotlib.font_manager import findfont
from PIL import Image as Picture
from PIL import ImageDraw, ImageFont

from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.progress import Progress
from tendon_mj.replay.frames import POSE, Frames
from tendon_mj.view.render.cable import (
    GUIDE_COLOUR,
    add_cable,
    cable_radius,
    tension_scale,
    without_tendons,
)
from tendon_mj.view.render.offscreen import Image, Offscreen, find_camera, project
from tendon_mj.view.render.panel import HEIGHT, INK, Panel
from tendon_mj.whole_file import whole_file

_PANEL = 0.3  # share of the width that the panel takes
_SMALLEST = 64  # [pixels]
_QUALITY = 20  # constant rate factor of H.264, less is better


def render_clip(
    model: mujoco.MjModel,
    frames: Frames,
    path: Path,
    *,
    width: int = 1280,
    height: int = 720,
    camera: str | mujoco.MjvCamera | None = None,
    progress: Progress | None = None,
) -> Path:
    """Draw recorded frames as an MP4, tendons in sheaths coloured by their tension.

    A panel beside the picture has the colour bar, the tensions at both ends and the controls; a
    model without a sheath is shown without it.

    Args:
        model: to draw; it has the joints, tendons and actuators of the one that was recorded, and
            may have lights and a floor besides. It is not changed.
        frames: as `record_frames` returns them, or a `FrameRecorder` that a simulation was given.
        path: of the MP4; its folder is made if it is not there.
        width, height: of the clip [pixels], even numbers.
        camera: name of one of the model's; default: its first, or a view of the whole model.
        progress: called with what is being done, how much is done, and of how much.

    Returns:
        ``path``.

    Raises:
        EngineError: no OpenGL is to be had; the message says what to install or set.
        UnknownNameError: no such camera.
        InvalidValueError: a size out of range, or frames of another model.
    """
    for name, size in (("width", width), ("height", height)):
        if size < _SMALLEST or size % 2:
            raise InvalidValueError(f"{name} = {size} [pixels] must be even and ≥ {_SMALLEST}")
    sizes = frames.poses.shape[1], frames.controls.shape[1]
    needed = mujoco.mj_stateSize(model, POSE), model.nu
    if sizes != needed:
        raise InvalidValueError(
            f"the frames are of another model: their poses and controls have {sizes} numbers, "
            f"the model's {needed}"
        )
    view = find_camera(model, camera)
    panel = round(_PANEL * width) if frames.cables else 0
    path.parent.mkdir(parents=True, exist_ok=True)
    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    painter = _FramePainter(model, frames, view, width, height, panel)
    try:
        with (
            whole_file(path) as made,
            mediapy.VideoWriter(made, (height, width), fps=frames.fps, crf=_QUALITY) as writer,
        ):
            for k in range(len(frames.time)):
                writer.add_image(painter.draw(k))
                if progress:
                    progress("draw", k + 1, len(frames.time))
    except RuntimeError as error:
        raise EngineError(f"{path}: ffmpeg could not write the clip: {error}") from error
    finally:
        painter.close()
    return path


class _FramePainter:
    """Frames as pictures: the scene on the left, the panel on the right."""

    def __init__(
        self,
        model: mujoco.MjModel,
        frames: Frames,
        camera: mujoco.MjvCamera,
        width: int,
        height: int,
        panel: int,
    ) -> None:
        self._frames, self._camera = frames, camera
        self._model = without_tendons(model)
        self._data = mujoco.MjData(self._model)
        self._size = (width - panel, height)
        scale = tension_scale(frames.cables) if frames.cables else Normalize()
        self._scale, self._radius = scale, cable_radius(model, frames.cables)
        self._panel = Panel(model, frames, scale, panel, height) if frames.cables else None
        size = max(6, round(17 * height / HEIGHT))
        self._font = ImageFont.truetype(findfont("DejaVu Sans"), size)
        self._offscreen = Offscreen(self._model, width - panel, height)

    def draw(self, k: int) -> Image:
        """(height, width, 3) picture of frame ``k``."""
        mujoco.mj_setState(self._model, self._data, self._frames.poses[k], POSE)
        mujoco.mj_fwdPosition(self._model, self._data)
        image = self._offscreen.draw(
            self._data, self._camera, lambda scene: self._add_cables(scene, k)
        )
        image = self._label_ends(image, k)
        return image if self._panel is None else np.hstack([image, self._panel.draw(k)])

    def close(self) -> None:
        """Free the graphics memory."""
        self._offscreen.close()

    def _add_cables(self, scene: mujoco.MjvScene, k: int) -> None:
        for cable in self._frames.cables.values():
            add_cable(scene, cable.points[k], cable.tensions[k], self._scale, self._radius)

    def _label_ends(self, image: Image, k: int) -> Image:
        """Write beside the cables which end is which, once where several begin together."""
        picture = Picture.fromarray(image)
        draw = ImageDraw.Draw(picture)
        written: list[tuple[str, np.ndarray]] = []
        size = self._font.size
        for cable in self._frames.cables.values():
            seen = project(self._offscreen.scene, cable.points[k], *self._size)
            for text, end in (("input", 0), ("output", -1)):
                away = seen[end] - np.nanmean(seen, axis=0)
                spot = seen[end] + 2.4 * size * away / max(float(np.linalg.norm(away)), 1.0)
                near = [t for t, s in written if t == text and np.abs(s - spot).max() < 4 * size]
                if np.isfinite(spot).all() and not near:
                    draw.text(tuple(spot), text, fill=INK, font=self._font, anchor="mm")
                    written.append((text, spot))
        if written:
            self._explain_guides(draw)
        return np.array(picture)

    def _explain_guides(self, draw: ImageDraw.ImageDraw) -> None:
        size = float(self._font.size)
        x, y, radius = 1.6 * size, self._size[1] - 1.8 * size, 0.35 * size
        draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=GUIDE_COLOUR)
        text = "guide: the sheath bends the tendon here and rubs on it"
        draw.text((x + size, y), text, fill=INK, font=self._font, anchor="lm")
