"""Explanations of one change: which one is named, and which ones explain it as well."""

import numpy as np

from tendon_mj.lab.fleet.number import Number
from tendon_mj.lab.fleet.series import Series, explanation


def series(name, identifier, square):
    square = np.array(square)
    return Series(
        number=Number(name, identifier, "-", 0.1),
        parameter=name,
        unit="-",
        probe=0.1,
        values=np.ones(square.size),
        errors=np.ones(square.size),
        square=square,
        before=10.0 * square,
        range=np.array([0.0, 2.0]),
        others={},
    )


def test_of_explanations_alike_the_uncertain_parameter_is_named():
    bend = series("sheath.drawn_bend", "bend_angle", [1.0, 1.2, 0.9])
    friction = series("sheath.friction", "", [1.0 + 1e-6, 1.2 + 1e-6, 0.9 + 1e-6])
    first, rivals = explanation([bend, friction])
    assert first is friction
    assert rivals == [bend]


def test_what_leaves_notably_more_in_every_recording_is_no_rival():
    play = series("sheath.backlash", "backlash", [1.0, 1.2, 0.9])
    friction = series("sheath.friction", "", [1.5, 1.8, 1.4])
    assert explanation([play, friction]) == (play, [])


def test_what_leaves_more_in_one_recording_alone_is_a_rival():
    play = series("sheath.backlash", "backlash", [1.0, 1.0, 1.0, 1.0])
    creep = series("sheath.creep", "creep", [0.9, 1.0, 1.0, 2.0])
    assert explanation([play, creep]) == (play, [creep])
