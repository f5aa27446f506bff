"""Tables of names, with a line on each: of a topic before its page, of all in `docs/api`."""

import re
from pathlib import Path

_OVERVIEW = "docs/api"
_DIRECTIVE = re.compile(r"^\.\. (currentmodule|autofunction|autoclass):: (\S+)$", re.M)


def _table(text: str) -> str:
    """Table of the functions and classes that a page documents."""
    module, names = "", []
    for kind, name in _DIRECTIVE.findall(text):
        if kind == "currentmodule":
            module = name
        else:
            names.append(f"   ~{module}.{name}")
    listed = "\n".join(names)
    return f"```{{eval-rst}}\n.. autosummary::\n   :nosignatures:\n\n{listed}\n```\n"


def _add(app, page: str, source: list[str]) -> None:
    if page == _OVERVIEW:
        for path in re.findall(r"^api/\w+$", source[0], re.M):
            text = (Path(app.srcdir) / "docs" / f"{path}.md").read_text("utf-8")
            title = text.partition("\n")[0].removeprefix("# ")
            source[0] += f"\n## [{title}]({path}.md)\n\n{_table(text)}"
    elif page.startswith(f"{_OVERVIEW}/"):
        heading, _, rest = source[0].partition("\n")
        source[0] = f"{heading}\n\n{_table(source[0])}\n{rest}"


def setup(app):
    """Add the tables when a page is read."""
    app.connect("source-read", _add)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
