"""Arrows of contact forces, drawn over a picture."""

from __future__ import annotations

import numpy as np
from PIL import Image as Picture
from PIL import ImageDraw, ImageFont

from tendon_mj.show.render.labels import free_spot
from tendon_mj.show.render.offscreen import Image
from tendon_mj.typing import FloatArray

_COLOUR, _RIM = (150, 20, 40), (255, 255, 255)
_FINE = 4  # pixels drawn for each one shown
_LEAST = 0.2  # force that is shown, over the largest in the clip


def draw_arrow(
    image: Image,
    start: FloatArray,
    end: FloatArray,
    text: str,
    font: ImageFont.FreeTypeFont,
    written: list[FloatArray],
) -> Image:
    """Draw an arrow with its value beyond its head.

    Args:
        image: (height, width, 3), not changed.
        start, end: columns and rows [pixels].
        text: beside the head.
        font: of the text.
        written: places of other arrows' values, from which this one's keeps clear; it is added.
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
    patch = patch.resize(tuple(_FINE * (high - low)), Picture.Resampling.BICUBIC)
    draw = ImageDraw.Draw(patch)
    side = np.array([-way[1], way[0]])
    for colour, rim in ((_RIM, 0.12 * font.size), (_COLOUR, 0.0)):
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
        draw.polygon([tuple(_FINE * (corner - low)) for corner in outline], fill=colour)
    picture.paste(patch.resize(tuple(high - low), Picture.Resampling.BOX), tuple(low))
    anchor = "rm" if way[0] < 0 else "lm"
    spot = free_spot(end + 0.5 * font.size * way, written, font.size)
    ImageDraw.Draw(picture).text(
        tuple(spot), text, fill=_COLOUR, font=font, anchor=anchor, stroke_width=2, stroke_fill=_RIM
    )
    return np.array(picture)


def arrow_scale(contacts: tuple[FloatArray, ...], length: float) -> float:
    """Length of an arrow over its force [m/N] for the largest to have a length [m]."""
    largest = max((largest_force(rows) for rows in contacts), default=0.0)
    return length / largest if largest > 0.0 else 0.0


def largest_force(rows: FloatArray) -> float:
    """Largest force of one frame's contacts [N]; 0 without one."""
    return float(np.linalg.norm(rows[:, 3:], axis=1).max()) if len(rows) else 0.0


def shown_contacts(rows: FloatArray, largest: float) -> FloatArray:
    """The contacts of a frame whose force is not negligible beside the largest of the clip [N]."""
    kept: FloatArray = rows[np.linalg.norm(rows[:, 3:], axis=1) > _LEAST * largest]
    return kept
