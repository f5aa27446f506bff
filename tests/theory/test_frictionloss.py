"""The frictionloss of a driven tendon takes what the capstan equation takes, in any array."""

import math

import numpy as np
import pytest

from tendon_mj import frictionloss

TENSION, BEND, FRICTION = [0.0, -3.0, 10.0, 10.0, 25.0], [1.0, 1.0, 0.0, 2.0, 0.5], 0.2
VELOCITY = [-1.0, -1.0, 1.0, -0.5, 0.1]


@pytest.mark.parametrize(("velocity", "sign"), [(-0.1, -1.0), (0.1, 1.0)])
def test_what_arrives_is_the_capstan_equation(velocity, sign):
    loss = frictionloss(10.0, math.pi, 0.3, velocity)
    arrives = 10.0 + sign * loss  # more pulls at the load where the tendon is pulled out
    assert arrives == pytest.approx(10.0 * math.exp(sign * 0.3 * math.pi), rel=1e-14)


def test_no_tension_no_bend_and_no_friction_take_nothing():
    assert frictionloss(np.array(TENSION), np.array(BEND), 0.2, np.array(VELOCITY))[:3].max() == 0
    assert frictionloss(10.0, 1.0, 0.0, 1.0) == 0.0


@pytest.mark.parametrize("package", ["torch", "jax.numpy"])
def test_another_packages_arrays_have_the_numbers_of_numpy(package):
    xp = pytest.importorskip(package)
    given = [np.array(values, np.float32) for values in (TENSION, BEND, VELOCITY)]
    expected = frictionloss(*given[:2], FRICTION, given[2])
    assert expected.dtype == np.float32
    tension, bend, velocity = map(xp.asarray, given)
    loss = frictionloss(tension, bend, FRICTION, velocity)
    assert isinstance(loss, type(tension))
    assert loss.dtype == tension.dtype
    np.testing.assert_allclose(np.asarray(loss), expected, rtol=1e-5)
