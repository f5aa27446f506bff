"""Clip of recorded frames, drawn offscreen, the tendons coloured by the tension along them."""

from __future__ import annotations

import contextlib
import itertools
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import imageio_ffmpeg
import mujoco
import numpy as np
from matplotlib.colors import Normalize
from matplotlib.font_manager import findfont
from PIL import Image as Picture
from PIL import ImageDraw, ImageFont

from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.lab.frames import POSE, Frames
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.units import force_unit
from tendon_mj.plugin import sheaths
from tendon_mj.show import style
from tendon_mj.show.render import offscreen
from tendon_mj.show.render.panel import Panel, listed, tendon_colours, text_scale, unit_of_forces
from tendon_mj.show.render.surroundings import poses_of, to_show
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_PANEL, _PANEL_BELOW = 0.34, 0.6  # share of the width, or of the height, that the panel takes
_SMALLEST_SIZE, _LARGEST_SIZE = 64, 8192  # [pixels]
_QUALITY = 4  # constant rate factor of H.264, less is better: the colour of a tendon is a reading
# Stated in the file, lest players guess: they take another matrix of colours for large pictures.
_COLOUR_FLAGS: Final = (
    "-vf",
    "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bicubic",
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"),
)
_HALO = 2  # width around what is written [pixels]
_ENDS = 2  # of a tendon; the other points of its path are guides
_ARROW = 0.12  # length of the largest force's arrow over the size of all cables
_ARROW_COLOUR, _TWIN_ARROW = "#961428", style.GREY
_ARROW_SIGN = "\N{HEAVY ROUND-TIPPED RIGHTWARDS ARROW}"
_OVERSAMPLING = 4  # pixels drawn for each one shown
_LEAST_FORCE = 0.2  # force that is shown, over the largest in the clip


def render_clip(
    model: mujoco.MjModel,
    frames: Frames,
    path: Path,
    *,
    width: int = 1280,
    height: int = 720,
    camera: str | mujoco.MjvCamera | None = None,
    twin: Frames | None = None,
    caption: str = "",
    progress: Progress | None = None,
) -> Path:
    """Draw recorded frames as an MP4, tendons in sheaths coloured by their tension.

    H.264 changes colours: half of a tendon's pixels are within one of the bar's 256 steps of what
    was drawn, 19 of 20 within three. The frames that `draw_frames` gives are exact.

    A panel next to the picture, or below it in a clip that is higher than wide, has the colour bar,
    forces, tensions, joint angles and controls, as many as fit; a model without a sheath is shown
    without it.

    Args:
        model: to draw; it has the joints, tendons and actuators of the one that was recorded, and
            may have lights and a floor besides. It is not changed.
        frames: as `record_frames` returns them, or a `FrameRecorder` that a simulation was given.
        path: of the MP4; its folder is made if it is not there.
        width, height: of the clip [pixels], even numbers.
        camera: name of one of the model's; default: the first that shows the tendons, or one that
            frames them.
        twin: frames of the same motion without friction, drawn in grey behind the model.
        caption: sentence above or below the scene, such as that of `friction_sentence`.
        progress: called with the activity, the number of frames done, and of all.

    Returns:
        ``path``.

    Raises:
        EngineError: no OpenGL is available; the message says what to install or set.
        UnknownNameError: no such camera.
        InvalidValueError: a size out of range, or frames of another model.
    """
    check_size(width, height)
    size: Any = {"width": width, "height": height}
    images = draw_frames(model, frames, **size, camera=camera, twin=twin, caption=caption)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with whole_file(path) as made:
            writer = imageio_ffmpeg.write_frames(
                str(made),
                (width, height),
                fps=frames.fps,
                codec="libx264",
                quality=None,  # but that of the parameters
                macro_block_size=2,
                output_params=["-crf", str(_QUALITY), *_COLOUR_FLAGS],
            )
            with contextlib.closing(writer):
                writer.send(None)
                for k, image in enumerate(images):
                    writer.send(np.ascontiguousarray(image))
                    if progress:
                        progress("draw", k + 1, len(frames.time))
            written, _ = imageio_ffmpeg.count_frames_and_secs(str(made))
            if written != len(frames.time):  # as where the disk is full, which ffmpeg alone notices
                raise OSError(f"{written} of {len(frames.time)} frames were written")
    except (OSError, RuntimeError) as error:
        raise EngineError(f"{path}: ffmpeg could not write the clip: {error}") from error
    return path


def draw_frames(
    model: mujoco.MjModel,
    frames: Frames,
    *,
    width: int,
    height: int,
    camera: str | mujoco.MjvCamera | None = None,
    twin: Frames | None = None,
    caption: str = "",
    dark: bool = False,
) -> Iterator[offscreen.Image]:
    """The (height, width, 3) pictures of a clip one after the other; see `render_clip`.

    With ``dark`` the sky is that of a dark page and text is light; a floor keeps its colour.
    """
    sizes = frames.poses.shape[1], frames.controls.shape[1]
    needed = mujoco.mj_stateSize(model, POSE), model.nu
    if sizes != needed:
        raise InvalidValueError(
            f"the frames are of another model: their poses and controls have {sizes} numbers, "
            f"the model's {needed}"
        )
    if twin is not None and twin.poses.shape != frames.poses.shape:
        raise InvalidValueError(
            f"the twin has {twin.poses.shape[0]} frames of {twin.poses.shape[1]} numbers, the "
            f"motion {frames.poses.shape[0]} of {frames.poses.shape[1]}"
        )
    poses = poses_of(model, frames)
    view = offscreen.find_camera(model, camera, poses)
    size = panel = width, height
    if frames.cables and width < height:
        panel = width, round(_PANEL_BELOW * height)
        size = width, height - panel[1]
    elif frames.cables:
        panel = 2 * round(0.5 * _PANEL * width), height
        size = width - panel[0], height
    theme = style.DARK if dark else style.LIGHT
    return _FramePainter(model, frames, view, poses, size, panel, twin, caption, theme).pictures()


def check_size(width: int, height: int) -> None:
    """Check the size of a clip."""
    for name, size in (("width", width), ("height", height)):
        if size % 2 or not _SMALLEST_SIZE <= size <= _LARGEST_SIZE:
            raise InvalidValueError(
                f"{name} = {size} [pixels] must be even, ≥ {_SMALLEST_SIZE} and ≤ {_LARGEST_SIZE}"
            )


class _FramePainter:
    """Frames as pictures: the scene, and the panel on its right or below it."""

    def __init__(
        self,
        model: mujoco.MjModel,
        frames: Frames,
        camera: mujoco.MjvCamera,
        poses: FloatArray,
        size: tuple[int, int],
        panel: tuple[int, int],
        twin: Frames | None,
        caption: str,
        theme: style.Theme,
    ) -> None:
        self._frames, self._camera, self._twin, self._size = frames, camera, twin, size
        self._drawn = frames.drawn
        self._theme, self._caption = theme, caption
        self._model = offscreen.without_tendons(to_show(model), frames.cables)
        self._data = mujoco.MjData(self._model)
        self._scale = offscreen.colour_limits(frames.cables) if frames.cables else Normalize()
        self._radius = offscreen.cable_radius(model, self._drawn)
        self._panel = (
            Panel(model, frames, self._scale, *panel, twin, theme) if frames.cables else None
        )
        self._names = {
            name: (sheaths(model)[name].tendon, style.on_theme(colour, theme))
            for name, colour in tendon_colours(model, frames.cables).items()
        }
        points = max(6, round(15 * text_scale(size[1])))
        self._font = ImageFont.truetype(findfont("DejaVu Sans"), points)
        self._written: dict[str, Any] = {"font": self._font, **_halo(theme)}
        pressed = [*frames.contacts, *(twin.contacts if twin else ())]
        self._largest = max((_norms(rows).max(initial=0.0) for rows in pressed), default=0.0)
        self._unit = unit_of_forces(frames) if frames.cables else force_unit([self._largest])
        length = _ARROW * offscreen.cables_size(model, self._drawn)
        self._arrow = length / self._largest if self._largest > 0.0 else 0.0  # [m/N]
        self._legend_row: float | None = None
        sky = "" if theme is style.LIGHT else theme.background
        self._offscreen = offscreen.Offscreen(self._model, *size, sky, poses=poses)
        self._ghost = (
            offscreen.Ghost(self._model, self._offscreen, camera) if twin is not None else None
        )

    def pictures(self) -> Iterator[offscreen.Image]:
        """All frames as pictures; the graphics memory is free after the last."""
        with self._offscreen:
            for k in range(len(self._frames.time)):
                yield self._draw(k)

    def _draw(self, k: int) -> offscreen.Image:
        """(height, width, 3) picture of frame ``k``."""
        mujoco.mj_setState(self._model, self._data, self._frames.poses[k], POSE)
        mujoco.mj_fwdPosition(self._model, self._data)

        cables = offscreen.cables_at(self._drawn, k, self._scale, self._radius)
        image = self._offscreen.draw(self._data, self._camera, cables)
        if self._ghost is not None and self._twin is not None:
            image = self._ghost.behind(image, self._twin.poses[k])
        labels = list[FloatArray]()
        for frames, colour in ((self._twin, _TWIN_ARROW), (self._frames, _ARROW_COLOUR)):
            contacts = frames.contacts[k] if frames else np.empty((0, 6))
            for contact in contacts[_norms(contacts) > _LEAST_FORCE * self._largest]:
                ends = contact[:3] + np.outer((0.0, self._arrow), contact[3:])
                start, end = offscreen.project(self._offscreen.scene, ends, *self._size)
                force = self._unit.factor * np.linalg.norm(contact[3:])
                text, drawn = f"{force:.1f} {self._unit.symbol}", (colour, self._theme)
                image = draw_arrow(image, start, end, text, self._font, labels, *drawn)
        image = self._label_ends(image, k)
        if self._panel is None:
            return image
        beside = self._panel.draw(k)
        return np.concatenate([image, beside], axis=int(len(image) == len(beside)))

    def _label_ends(self, image: offscreen.Image, k: int) -> offscreen.Image:
        """Write the tendons' names next to their input ends, and a legend below."""
        picture = Picture.fromarray(image)
        draw = ImageDraw.Draw(picture)
        labels: list[FloatArray] = []
        size = self._font.size
        several = len(self._frames.cables) > 1
        scene, cables = self._offscreen.scene, self._frames.cables
        drawn = [name for name in listed(self._frames) if name in self._drawn]
        paths = {n: offscreen.project(scene, cables[n].points[k], *self._size) for n in drawn}
        for name, seen in paths.items():
            tendon, colour = self._names[name]
            if several and not self._inside(seen[0]):
                self._label_middle(draw, seen, tendon, colour, paths, labels)
                continue
            first, last = self._frames.cables[name].ends
            shown = [(tendon, 0)] if several else [("input", first), ("output", last + 1)]
            for text, end in shown:
                away = seen[end] - np.nanmean(seen[first : last + 2], axis=0)
                spot = seen[end] + 2.2 * size * away / max(float(np.linalg.norm(away)), 1.0)
                if self._inside(seen[end]) and np.isfinite(spot).all():
                    spot = free_spot(spot, labels, size)
                    wide = self._font.getlength(text) + 2.0
                    spot[0] -= wide if away[0] < 0.0 else 0.0
                    spot[0] = np.clip(spot[0], 2.0, max(2.0, self._size[0] - wide))
                    ink = colour if several else self._theme.ink
                    draw.text(tuple(spot), text, fill=ink, anchor="lm", **self._written)
        self._explain(picture, draw)
        return np.array(picture)

    def _inside(self, spot: FloatArray) -> bool:
        return bool(((spot > 0.0) & (spot < self._size)).all())

    def _label_middle(
        self,
        draw: ImageDraw.ImageDraw,
        seen: FloatArray,
        text: str,
        colour: str,
        paths: dict[str, FloatArray],
        labels: list[FloatArray],
    ) -> None:
        """Write a tendon's name next to its longest segment in the picture, on the free side."""
        spans = [s for s in itertools.pairwise(seen) if self._inside(s[0]) and self._inside(s[1])]
        if not spans:
            return
        start, end = max(spans, key=lambda span: float(np.linalg.norm(span[1] - span[0])))
        middle = 0.5 * (start + end)
        others = np.vstack(list(paths.values()))
        near = others[np.abs(others[:, 0] - middle[0]) < np.abs(end - start).max()]
        side = 1.0 if middle[1] >= np.nanmean(near[:, 1]) else -1.0
        spot = middle + np.array([0.0, 1.4 * side * self._font.size])
        spot = free_spot(spot, labels, self._font.size)
        draw.text(tuple(spot), text, fill=colour, anchor="mm", **self._written)

    def _explain(self, picture: Picture.Image, draw: ImageDraw.ImageDraw) -> None:
        """Explain the grey bead, the grey ghost and the arrows in a left corner."""
        size = float(self._font.size)
        x, radius = 1.4 * size, 0.35 * size
        lines = []
        if any(cable.points.shape[1] > _ENDS for cable in self._drawn.values()):
            lines.append(("guide that the tendon rubs on", offscreen.GUIDE_COLOUR, ""))
        if self._twin is not None:
            lines.append(
                ("without friction, the same controls", self._theme.ghost, self._theme.ink)
            )
        arrow = style.on_theme(_ARROW_COLOUR, self._theme)
        if self._largest > 0.0:
            lines.append(("contact force", arrow, ""))
        letter = self._font.getlength("e")
        columns = max(1, int((self._size[0] - 2.0 * x) / letter))
        lines += [(text, "", "") for text in textwrap.wrap(self._caption, columns)]
        if not lines:
            return
        high = 1.5 * size * (len(lines) - 1)
        if self._legend_row is None:  # the emptier corner of the first frame, for all of the clip
            wide = max(self._font.getlength(text) for text, _, _ in lines) + 2.0 * x

            def crowded(y: float) -> float:
                return float(np.std(np.array(picture.crop((0.0, y - size, wide, y + high + size)))))

            self._legend_row = min((self._size[1] - 1.2 * size - high, 1.2 * size), key=crowded)
        y = self._legend_row
        for text, colour, outline in lines:
            half = 2.0 * radius if outline else radius  # of the ghost a piece as of a finger
            box = [x - half, y - radius, x + half, y + radius]
            around = [box[0] - _HALO, box[1] - _HALO, box[2] + _HALO, box[3] + _HALO]
            if not colour:
                draw.text((0.7 * size, y), text, fill=self._theme.ink, anchor="lm", **self._written)
                y += 1.5 * size
                continue
            if colour == arrow:
                draw.text((x, y), _ARROW_SIGN, fill=arrow, anchor="mm", **self._written)
            else:
                draw.rounded_rectangle(around, radius + _HALO, fill=self._theme.background)
                draw.rounded_rectangle(box, radius, fill=colour, outline=outline or None)
            draw.text((2.4 * size, y), text, fill=self._theme.ink, anchor="lm", **self._written)
            y += 1.5 * size


def _halo(theme: style.Theme) -> dict[str, Any]:
    """Options of a text that stands out from the picture."""
    return {"stroke_width": _HALO, "stroke_fill": theme.background}


def _norms(contacts: FloatArray) -> FloatArray:
    """(k,) forces of a frame's contacts [N]."""
    return np.asarray(np.linalg.norm(contacts[:, 3:], axis=1))


def draw_arrow(
    image: offscreen.Image,
    start: FloatArray,
    end: FloatArray,
    text: str,
    font: ImageFont.FreeTypeFont,
    labels: list[FloatArray],
    colour: str = _ARROW_COLOUR,
    theme: style.Theme = style.LIGHT,
) -> offscreen.Image:
    """Draw an arrow between two pixels on a copy of a picture, with its value in front of its head.

    The value keeps clear of the places in ``labels``, and is added to them.
    """
    way = end - start
    length = float(np.linalg.norm(way))
    if not np.isfinite(length) or length < 1.0:
        return image
    way /= length
    wide = 0.24 * font.size
    head = min(1.1 * font.size, length)
    margin = 3 * font.size
    low = np.floor(np.minimum(start, end) - margin).astype(int)
    high = np.ceil(np.maximum(start, end) + margin).astype(int)
    low, high = np.maximum(low, 0), np.minimum(high, (image.shape[1], image.shape[0]))
    if (high <= low).any():
        return image
    picture = Picture.fromarray(image)
    patch = picture.crop((*low, *high))
    patch = patch.resize(tuple(_OVERSAMPLING * (high - low)), Picture.Resampling.BICUBIC)
    draw = ImageDraw.Draw(patch)
    side, ink = np.array([-way[1], way[0]]), style.on_theme(colour, theme)
    for fill, rim in ((theme.background, 0.12 * font.size), (ink, 0.0)):
        half, broad = 0.5 * wide + rim, 0.45 * font.size + rim
        tail, neck, tip = start - rim * way, end - head * way, end + 1.5 * rim * way
        outline = [
            tail + half * side,
            neck + half * side,
            neck - rim * way + broad * side,
            tip,
            neck - rim * way - broad * side,
            neck - half * side,
            tail - half * side,
        ]
        draw.polygon([tuple(_OVERSAMPLING * (corner - low)) for corner in outline], fill=fill)
    picture.paste(patch.resize(tuple(high - low), Picture.Resampling.BOX), tuple(low))
    anchor = "rm" if way[0] < 0 else "lm"
    spot = tuple(free_spot(end + 0.5 * font.size * way, labels, font.size))
    ImageDraw.Draw(picture).text(spot, text, fill=ink, font=font, anchor=anchor, **_halo(theme))
    return np.array(picture)


def free_spot(spot: FloatArray, taken: list[FloatArray], size: float) -> FloatArray:
    """The nearest pixel at or below ``spot`` that is clear of other labels, and is then taken."""
    place = spot.copy()
    while any((np.abs(place - other) < (5.0 * size, 1.25 * size)).all() for other in taken):
        place[1] += 0.3 * size
    taken.append(place.copy())
    return place
