"""Equations as pictures in the page, drawn by matplotlib: no script and no network is needed.

An equation that matplotlib cannot read is a warning, which `make docs` treats as an error.
"""

from html import escape

import numpy as np
from docutils import nodes
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath, TextToPath
from sphinx.util import logging

_SIZE = 100.0  # units of the picture in an em
_ZOOM = 1.15  # of an equation over the text around it
_FONT = FontProperties(family="STIXGeneral", math_fontfamily="stix")
_COMMANDS = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C"}


def picture(latex: str) -> str:
    """An equation as SVG in the colour of the text.

    Raises:
        ValueError: matplotlib cannot read it.
    """
    text = f"${' '.join(latex.split())}$"
    width, height, descent = TextToPath().get_text_width_height_descent(text, _FONT, ismath=True)
    em = _SIZE / _FONT.get_size_in_points()
    path = TextPath((0, 0), text, size=_SIZE, prop=_FONT)
    steps = []
    for points, code in path.iter_segments(simplify=False, curves=True):
        numbers = " ".join(
            f"{x:.1f}" for x in np.asarray(points) * np.tile([1, -1], len(points) // 2)
        )
        steps.append("Z" if code == Path.CLOSEPOLY else f"{_COMMANDS[code]}{numbers}")
    box = f"0 {-(height - descent) * em:.1f} {width * em:.1f} {height * em:.1f}"
    style = (
        f"height:{height * em * _ZOOM / _SIZE:.3f}em;"
        f"vertical-align:{-descent * em * _ZOOM / _SIZE:.3f}em"
    )
    return (
        f'<svg class="equation" role="img" aria-label="{escape(latex)}" viewBox="{box}" '
        f'style="{style}"><path fill="currentColor" d="{"".join(steps)}"/></svg>'
    )


def _draw(latex: str, node) -> str:
    try:
        return picture(latex)
    except ValueError as error:
        logging.getLogger(__name__).warning("equation %r: %s", node.astext(), error, location=node)
        return escape(node.astext())


def _inline(translator, node) -> None:
    translator.body.append(_draw(node.astext(), node))
    raise nodes.SkipNode


def _block(translator, node) -> None:
    full_size = node.astext().replace(r"\frac", r"\dfrac")  # as TeX has it in a line of its own
    translator.body.append(f'<div class="math">{_draw(full_size, node)}</div>\n')
    raise nodes.SkipNode


def setup(app):
    """Register the renderer."""
    app.add_html_math_renderer("mathtext", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
