"""Units as other programs write them are refused with the one that is meant."""

import pytest

from tendon_mj.lab.recordings.table_checks import name_fault


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("lever_degrees", "_deg"),
        ("cable_newtons", "_N"),
        ("force_n", "_N"),
        ("force_KN", "_kN"),
        ("load_nm", "_Nm"),
    ],
)
def test_the_unit_that_is_meant_is_in_the_message(name, unit):
    assert f"did you mean {unit!r}?" in name_fault(name)
