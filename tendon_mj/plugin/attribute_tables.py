"""Tables of attributes in the documentation, derived from the parameters' descriptions.

`python -m tendon_mj.plugin.attribute_tables docs/plugin.md` rewrites a page's generated blocks.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

from tendon_mj.plugin.sheath_plugin.attributes import ATTACHMENT
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS
from tendon_mj.sheath import Parameter


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _row(name: str, parameter: Parameter) -> tuple[str, ...]:
    default = "required" if parameter.required else f"{parameter.default or 0.0:g}"
    unit = "1" if parameter.unit == "-" else parameter.unit
    bounds = ", ".join(parameter.range.bounds()) or "finite"
    return f"`{name}`", parameter.symbol, parameter.text, unit, bounds, default


def parameter_table() -> str:
    """Markdown table of a sheath's numeric attributes."""
    head = ("attribute", "symbol", "meaning", "unit", "range", "default")
    return _table(head, (_row(name, parameter) for name, parameter in PARAMETERS.items()))


def attachment_table() -> str:
    """Markdown table of the attributes that attach a sheath to its model."""
    rows = ((f"`{n}`", a.text, a.kind, a.default) for n, a in ATTACHMENT.items())
    return _table(("attribute", "meaning", "value", "default"), rows)


TABLES = {"parameters": parameter_table, "attachment": attachment_table}


def regenerated(page: str) -> str:
    """A page with its generated blocks as the code has them now."""
    for name, table in TABLES.items():
        begin, end = f"<!-- generated: {name} -->", "<!-- end -->"
        block = f"{begin}\n{table()}\n{end}".replace("\\", r"\\")
        page = re.sub(f"{begin}.*?{end}", block, page, flags=re.S)
    return page


def main() -> None:
    """Rewrite the pages named on the command line."""
    for name in sys.argv[1:]:
        page = Path(name)
        page.write_text(regenerated(page.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    main()
