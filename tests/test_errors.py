"""Names that do not exist: what a message suggests and lists."""

import pytest

from tendon_mj.errors import unknown

ATTRIBUTES = ["friction", "axial_stiffness", "pretension", "creep", "slack", "backlash", "lag"]
PARAMETERS = [f"{tendon}_sheath.{name}" for tendon in ("flexor", "extensor") for name in ATTRIBUTES]


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        *(("mu", "friction"), ("μ", "friction"), ("EA", "axial_stiffness")),
        *(("T_0", "pretension"), ("frictoin", "friction")),
    ],
)
def test_symbols_and_misspelt_names_are_understood(name, meant):
    assert f"did you mean {meant!r}?" in unknown("parameter", name, ATTRIBUTES)
    here = f"flexor_sheath.{name}"
    assert f"did you mean 'flexor_sheath.{meant}'?" in unknown("parameter", here, PARAMETERS)


@pytest.mark.parametrize(
    ("name", "valid", "meant"),
    [("ab", "a", False), ("mA", "m", False), ("1", "10", False), ("a", "x.a", True)],
)
def test_a_single_letter_is_like_itself_only(name, valid, meant):
    assert (f"did you mean {valid!r}?" in unknown("column", name, [valid, "other"])) == meant


def test_a_name_that_begins_so_is_meant_before_one_that_sounds_alike():
    assert "did you mean 'biceps cable'?" in unknown(
        "tendon", "biceps", ["triceps", "biceps cable"]
    )
