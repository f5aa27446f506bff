"""An option of several values that is given twice has the values of both."""

import pytest

from tendon_mj.cli.main import COMMANDS
from tendon_mj.cli.repeated_options import gathered, options_of_several

SEVERAL = options_of_several(COMMANDS.values())


def test_the_commands_have_such_options():
    of_sweep = {"--outputs", "--parameter"}
    assert {"--change", "--exclude", "--hold-out", "--tendon"} | of_sweep == SEVERAL


def test_values_of_all_places_are_kept_in_their_order():
    given = ["replay", "a.csv", "--change", "x=1", "y=2", "--out", "o", "--change", "z=3"]
    expected = ["replay", "a.csv", "--out", "o", "--change", "x=1", "y=2", "z=3"]
    assert gathered(given, SEVERAL) == expected


@pytest.mark.parametrize(
    "given",
    [
        ["--change=*.friction=0.3", "--change=*.friction=0.9"],
        ["--change", "*.friction=0.3", "--change=*.friction=0.9"],
        ["--change=*.friction=0.3", "--change", "*.friction=0.9"],
    ],
)
def test_a_value_behind_an_equals_sign_is_one_more(given):
    expected = ["replay", "a.csv", "--change", "*.friction=0.3", "*.friction=0.9"]
    assert gathered(["replay", "a.csv", *given], SEVERAL) == expected


def test_what_follows_a_value_behind_an_equals_sign_is_not_its_neighbour():
    given = ["replay", "--change=x=1", "a.csv", "--out", "o"]
    assert gathered(given, SEVERAL) == ["replay", "a.csv", "--out", "o", "--change", "x=1"]


def test_underscores_are_hyphens():
    given = ["diagnose", "a", "--hold-out", "b", "--hold_out", "c", "--hold_out=d_e"]
    assert gathered(given, SEVERAL) == ["diagnose", "a", "--hold-out", "b", "c", "d_e"]


def test_of_other_options_the_last_counts_as_it_does_everywhere():
    given = ["replay", "a.csv", "--out", "x", "--out=y"]
    assert gathered(given, SEVERAL) == given
