"""The tables of attributes in docs/plugin.md, derived from the parameters' descriptions.

``python -m tests.plugin.test_attribute_tables`` rewrites them.
"""

import re
from pathlib import Path

from tendon_mj.plugin import PARAMETERS
from tendon_mj.plugin.sheath_plugin.attributes import ATTACHMENT, ATTRIBUTES

PAGE = Path(__file__).parents[2] / "docs" / "plugin.md"


def _table(head, rows):
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _row(name, parameter):
    default = "required" if parameter.required else f"{parameter.default or 0.0:g}"
    unit = "1" if parameter.unit == "-" else parameter.unit
    bounds = ", ".join(parameter.range.bounds()) or "finite"
    return f"`{name}`", parameter.symbol, parameter.text, unit, bounds, default


def parameter_table():
    """Markdown table of a sheath's numeric attributes."""
    head = ("attribute", "symbol", "meaning", "unit", "range", "default")
    return _table(head, (_row(name, parameter) for name, parameter in PARAMETERS.items()))


def attachment_table():
    """Markdown table of the attributes that attach a sheath to its model."""
    rows = ((f"`{n}`", a.text, a.kind, a.default) for n, a in ATTACHMENT.items())
    return _table(("attribute", "meaning", "value", "default"), rows)


TABLES = {"parameters": parameter_table, "attachment": attachment_table}


def regenerated(page):
    """A page with its generated blocks as the code has them now."""
    for name, table in TABLES.items():
        begin, end = f"<!-- generated: {name} -->", "<!-- end -->"
        block = f"{begin}\n{table()}\n{end}".replace("\\", r"\\")
        page = re.sub(f"{begin}.*?{end}", block, page, flags=re.S)
    return page


def test_the_page_has_the_tables_that_the_code_derives():
    page = PAGE.read_text("utf-8")
    assert regenerated(page) == page, "run python -m tests.plugin.test_attribute_tables"


def test_every_attribute_has_a_row():
    page = "".join(table() for table in TABLES.values())
    assert all(f"| `{name}` |" in page for name in ATTRIBUTES)


if __name__ == "__main__":
    PAGE.write_text(regenerated(PAGE.read_text("utf-8")), "utf-8")
