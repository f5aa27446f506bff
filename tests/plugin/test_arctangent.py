"""The angle of a direction, against the C library's."""

import numpy as np
import pytest

from tendon_mj.plugin.sheath_plugin.path import arctangent

DIRECTIONS = np.concatenate(
    [
        np.linspace(0.0, np.pi, 20_001),
        np.logspace(-300.0, 0.0, 2_000),
        np.pi - np.logspace(-15.0, 0.0, 2_000),
    ]
)


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e6])
def test_the_angle_is_that_of_the_c_library_but_for_two_roundings(length):
    y, x = length * np.abs(np.sin(DIRECTIONS)), length * np.cos(DIRECTIONS)
    angle = np.array([arctangent(*direction) for direction in zip(y, x, strict=True)])
    expected = np.arctan2(y, x)
    assert (np.abs(angle - expected) <= 2.0 * np.spacing(expected)).all()


def test_it_grows_with_the_direction_across_the_seams_of_its_ranges():
    for seam in np.pi * np.array([1.0, 3.0, 5.0, 7.0]) / 8.0:
        around = seam + 1e-9 * np.linspace(-1.0, 1.0, 201)
        angle = [arctangent(np.sin(direction), np.cos(direction)) for direction in around]
        assert (np.diff(angle) > 0.0).all()


def test_nothing_has_no_direction():
    assert arctangent(0.0, 0.0) == 0.0
