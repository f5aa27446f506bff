"""Values in the units in which engineers read them."""

import math

import pytest

from tendon_mj.lab.units import engineering_unit, force_unit, quantity
from tendon_mj.plugin import GAINS, PARAMETERS


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (0.012, "N m", "12 mN m"),
        (4.2e-5, "m", "42 µm"),
        (9.9999e-4, "m", "1 mm"),
        (20e3, "N", "20 kN"),
        (2e6, "N", "2 MN"),
        (0.139, "N", "139 mN"),
        (math.pi, "rad", "180°"),
        (0.5, "rad/s", "28.6°/s"),
        (-0.02, "s", "-20 ms"),
        (6.06e-5, "m/N", "60.6 µm/N"),
        (0.004, "N s", "4 mN s"),
        (0.02, "1/s", "2 %/s"),
        (0.5, "1/m", "50 %/m"),
        (0.18, "-", "0.18"),
        (0.18, "", "0.18"),
        (3.0, "1", "3"),
        (0.05, "kg", "50 g"),
        (2.0, "kg", "2 kg"),
        (1e-6, "kg m²", "10 g cm²"),
        (0.00229, "kg m²", "0.00229 kg m²"),
        (0.0, "N m", "0 N m"),
        (9.81, "m/s²", "9.81 m/s²"),
        (2.5, "noise", "2.5 noise"),
    ],
)
def test_a_value_is_written_as_engineers_read_it(value, unit, said):
    assert quantity(value, unit) == said


@pytest.mark.parametrize(
    ("forces", "symbol"),
    [
        ([], "N"),
        ([0.2, 0.9], "mN"),
        ([0.2, 1.0], "N"),
        ([9000.0, 3.0], "N"),
        ([1e4], "kN"),
        ([math.nan, 400e3], "kN"),
        ([9e6], "kN"),
        ([1e7], "MN"),
    ],
)
def test_forces_that_are_shown_together_have_at_most_four_digits(forces, symbol):
    assert force_unit(forces).symbol == symbol


@pytest.mark.parametrize(
    "unit", ["m", "N", "N m", "s", "rad", "kg m²", "N/m", "kg", "m/s²", "m/N", "1/s"]
)
@pytest.mark.parametrize("power", range(-8, 9))
def test_a_value_stays_the_same_quantity(unit, power):
    """Written in an engineering unit and back, whatever its size."""
    symbol, factor = engineering_unit(unit, [10.0**power])
    scale = {"M": 1e6, "k": 1e3, "m": 1e-3, "µ": 1e-6}
    other = {"°": math.pi / 180.0, "g cm²": 1e-7, "g": 1e-3, "%/s": 1e-2, unit: 1.0}
    one = other.get(symbol) or scale[symbol[0]]  # in SI
    assert factor * one == pytest.approx(1.0)


def test_every_parameter_s_unit_is_known():
    """A small value of none of them is written as a power of ten, a ratio or a count aside."""
    for name, parameter in {**PARAMETERS, **GAINS}.items():
        if parameter.unit not in ("-", "1"):
            assert "e-" not in quantity(2.5e-4, parameter.unit), name


def test_what_is_not_finite_does_not_choose_a_unit():
    assert engineering_unit("m", [math.inf, math.nan, 2e-3]).symbol == "mm"
    assert engineering_unit("m", []).symbol == "m"
