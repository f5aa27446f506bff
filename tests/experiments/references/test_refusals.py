"""The reference models refuse bad arguments, instead of answering with NaN or never."""

import numpy as np
import pytest

from experiments import references
from tendon_mj.errors import InvalidValueError
from tests.refusals import refusing

SHEATH = {"length": 0.5, "axial_stiffness": 20e3, "pretension": 20.0}


def chain(n=4, **changes):
    given = {"bend_angle": np.pi, "static_friction": 0.1, **SHEATH, **changes}
    return references.uniform_chain(n, **given)


def test_an_exponent_beyond_every_number_is_refused():
    with refusing(InvalidValueError, "700"):
        chain(static_friction=300.0)


@pytest.mark.parametrize("n", [np.nan, np.inf, 2.5, 0, [4]])
def test_a_number_of_elements_is_whole(n):
    with refusing(InvalidValueError, "n is"):
        chain(n)


@pytest.mark.parametrize("name", ["mass", "damping", "static_friction", "friction_force", "length"])
def test_one_number_is_not_a_list(name):
    with pytest.raises(InvalidValueError, match=f"{name} is .* one number"):
        chain(**{name: [1.0, 2.0]})


def test_a_step_that_would_never_end_is_refused():
    with refusing(InvalidValueError, "time_step"):
        references.simulate_chain(chain(), [0.0, 1.0], input_tension=[20.0, 21.0], time_step=1e-300)


def test_a_list_serves_as_a_history():
    run = references.simulate_chain(chain(), [0.0, 0.1], input_tension=[20.0, 20.0])
    assert run.output_tension == pytest.approx(20.0)


def test_a_bend_that_does_not_start_at_zero_is_refused():
    with refusing(InvalidValueError, "start at 0"):
        references.continuum(lambda x: 2.0, friction=0.1, **SHEATH)


def test_a_straight_sheath_may_be_a_constant_function():
    straight = references.continuum(lambda x: 0.0, friction=0.1, **SHEATH)
    run = references.simulate_continuum(straight, input_tension=[20.0, 30.0])
    assert run.output_tension[-1] == pytest.approx(30.0)
