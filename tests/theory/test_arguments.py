"""Arguments broadcast; one out of its range is refused by its name, with its value."""

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError
from tendon_mj.theory import (
    apparent_stiffness,
    displacement,
    driven_tensions,
    equivalent_backlash,
    output_tension,
    reversal_backlash,
    transmission_stiffness,
)
from tendon_mj.theory.history import TensionMemory
from tendon_mj.theory.stiffness import tendon_stiffness
from tests.refusals import refusing

EA, LENGTH, SPRING, NAN, INF = 20e3, 0.5, 8e3, np.nan, np.inf
SHEATH = (1.0, 20.0, EA, LENGTH)
CALLS = [
    (tendon_stiffness, (0.0, 1.0), "axial_stiffness | 0.0"),
    (tendon_stiffness, (1.0, [1.0, -2.0]), "length | -2.0"),
    (apparent_stiffness, (NAN, 1.0, 1.0), "lam | nan"),
    (equivalent_backlash, (1.0, -1.0, 1.0, 1.0), "pretension | >= 0 | -1.0"),
    (reversal_backlash, (1.0, -1.0, 1.0, 1.0), "tension | >= 0 | -1.0"),
    (transmission_stiffness, (1.0, 1.0, 1.0, NAN), "environment_stiffness | nan"),
    (transmission_stiffness, (1.0, 1.0, 1.0, 1.0, -1.0), "sensor_stiffness | -1.0"),
    (output_tension, ([1.0, 0.0], 1.0, 20.0), "input_tension | > 0 | 0.0"),
    (output_tension, (1.0, 1.0, 20.0), "input_tension | history"),
    (output_tension, ([1.0], 1.0, 0.0), "pretension | 0.0"),
    (output_tension, ([1.0], NAN, 20.0), "lam | nan"),
    (displacement, ([1.0], 1.0, 20.0, 0.0, LENGTH), "axial_stiffness | 0.0"),
    (displacement, ([1.0], 1.0, 20.0, EA, 0.0), "length | 0.0"),
    (displacement, ([1.0], *SHEATH, 0.0), "output_stiffness | 0.0"),
    (driven_tensions, (0.1, *SHEATH), "displacement | history"),
    (driven_tensions, ([NAN], *SHEATH), "displacement | nan"),
    (driven_tensions, ([-0.1], *SHEATH), "displacement | slack | -0.1"),
    (driven_tensions, ([0.1], 1.0, 0.0, EA, LENGTH), "pretension | 0.0"),
    (driven_tensions, ([0.1], *SHEATH, -1.0), "output_stiffness | -1.0"),
    (TensionMemory, (0.0,), "pretension | > 0 | 0.0"),
    (TensionMemory(20.0).after, (-3.0,), "turning_points | -3.0"),
    (TensionMemory(20.0).tension, (-1.0,), "angle | -1.0"),
]


@pytest.mark.parametrize(("function", "arguments", "facts"), CALLS)
def test_a_value_out_of_range_is_named(function, arguments, facts):
    with refusing(InvalidValueError, facts):
        function(*arguments)


LAM, PULL, LONG = np.ones((4, 1, 1)), np.full((3, 1), 30.0), np.full(2, LENGTH)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (apparent_stiffness, (LAM, PULL, LONG)),
        (equivalent_backlash, (LAM, 20.0, PULL, LONG)),
        (reversal_backlash, (LAM, 20.0, PULL, LONG)),
        (transmission_stiffness, (LAM, EA, LENGTH, PULL, np.full(2, INF))),
    ],
)
def test_arguments_broadcast(function, arguments):
    assert function(*arguments).shape == (4, 3, 2)


def test_arguments_broadcast_behind_time():
    walk = 20.0 * np.exp(np.random.default_rng(5).normal(0.0, 0.2, (6, 1, 2)).cumsum(axis=0))
    lam, pretension = np.array([0.2, 0.4, 0.8])[:, None], np.array([20.0, 30.0])
    assert output_tension(walk, lam, pretension).shape == (6, 3, 2)
    xi = displacement(walk, lam, pretension, EA, LENGTH)
    np.testing.assert_array_equal(xi[:, 1, 1], displacement(walk[:, 0, 1], 0.4, 30.0, EA, LENGTH))
    both = driven_tensions(np.abs(xi), lam, pretension, EA, LENGTH)
    alone = driven_tensions(np.abs(xi[:, 1, 1]), 0.4, 30.0, EA, LENGTH)
    for several, one in zip(both, alone, strict=True):
        assert several.shape == (6, 3, 2)
        np.testing.assert_array_equal(several[:, 1, 1], one)
