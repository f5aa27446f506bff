"""The page of the commands: the help of each, as `tendon-mj COMMAND --help` prints it."""

import contextlib
import io
import os

_PAGE = "docs/commands"
_WIDTH = "88"  # columns, which a page has room for


def _help(command: str) -> str:
    """What `tendon-mj COMMAND --help` prints."""
    from tendon_mj.cli import main

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        main([command, "--help"])
    return said.getvalue().strip()


def _append(app, page: str, source: list[str]) -> None:
    """Add a section for every command to the page."""
    if page != _PAGE:
        return
    from tendon_mj.cli import COMMANDS

    width = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = _WIDTH
    try:
        sections = [f"## {name}\n\n```text\n{_help(name)}\n```\n" for name in COMMANDS]
    finally:
        os.environ.pop("COLUMNS")
        if width is not None:
            os.environ["COLUMNS"] = width
    source[0] += "\n" + "\n".join(sections)


def setup(app):
    """Append to the page when it is read."""
    app.connect("source-read", _append)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
