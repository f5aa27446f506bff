"""A solution is checked against what every segment then holds."""

import numpy as np
import pytest

from tendon_mj.sheath import solve_flow
from tendon_mj.sheath.tension_by_sweep import _holds
from tests.sheath.tendons import tendon, uniform


def solved(strain=1e-3):
    segments, guides = uniform(8, 0.5, strain)
    segments["stored"][0] *= 0.99999  # wound in
    assert solve_flow(segments, guides)
    assert _holds(segments, guides, 0)
    return segments, guides


@pytest.mark.parametrize("more", [1e-9, -1e-9])
@pytest.mark.parametrize("segment", range(9))
def test_a_taut_segment_with_more_or_less_than_its_tension_says_is_found_out(segment, more):
    segments, guides = solved()
    segments["stored"][segment] += more
    assert not _holds(segments, guides, 0)


def test_a_slack_segment_may_hold_more_and_not_less():
    segments, guides = tendon([0.1] * 4, [-1e-3] * 4, np.full(3, 0.3), 0.2, 0.2)
    assert solve_flow(segments, guides)
    assert not segments["tension"].any()
    segments["stored"][1] += 1e-3
    assert _holds(segments, guides, 0)
    segments["stored"][1] -= 3e-3
    assert not _holds(segments, guides, 0)
