"""The tables of attributes in the documentation are those of the code."""

from pathlib import Path

import pytest

from tendon_mj.plugin.attribute_tables import TABLES, regenerated
from tendon_mj.plugin.sheath_plugin.attributes import ATTRIBUTES

PAGE = Path(__file__).parents[2] / "docs" / "plugin.md"


def test_the_page_has_the_tables_that_the_code_derives():
    page = PAGE.read_text("utf-8")
    assert regenerated(page) == page, f"run python -m tendon_mj.plugin.attribute_tables {PAGE}"


@pytest.mark.parametrize("name", list(TABLES))
def test_a_changed_table_is_restored(name):
    page = PAGE.read_text("utf-8")
    table = TABLES[name]()
    assert table in page
    assert regenerated(page.replace(table, "gone")) == page


def test_every_attribute_has_a_row():
    page = "".join(table() for table in TABLES.values())
    assert all(f"| `{name}` |" in page for name in ATTRIBUTES)
