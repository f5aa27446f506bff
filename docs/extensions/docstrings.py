"""Docstrings as they are written, plain text with `names`, for a reader of reStructuredText."""

import re

_LITERAL = re.compile(r"(`+)(.+?)\1")
_MARKUP = re.compile(r"([\\*|]|(?<=\w)_(?!\w))")  # what would begin or end markup


def _escaped(line: str) -> str:
    """A line whose `names` are literals and whose other characters stand for themselves."""
    parts, end = [], 0
    for found in _LITERAL.finditer(line):
        parts += [_MARKUP.sub(r"\\\1", line[end : found.start()]), f"``{found[2]}``"]
        end = found.end()
    return "".join(parts) + _MARKUP.sub(r"\\\1", line[end:])


def _process(app, what, name, thing, options, lines: list[str]) -> None:
    lines[:] = [_escaped(line) for line in lines]


def setup(app):
    """Come before the extension that reads `Args:` and `Raises:`."""
    app.connect("autodoc-process-docstring", _process, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
