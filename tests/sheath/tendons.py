"""Tendons without MuJoCo: the solver's segments and guides, filled."""

import ctypes
import os

import numpy as np
from hypothesis import settings
from hypothesis import strategies as some

from tendon_mj.native import load
from tendon_mj.sheath.records import new_guides, new_segments

EVERY = settings(
    max_examples=int(os.environ.get("TENDON_MJ_EXAMPLES", "150")), derandomize=True, deadline=None
)
_PLACES, _BOOL = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64], ctypes.c_bool
_solve = ctypes.CFUNCTYPE(_BOOL, *_PLACES, _BOOL, _BOOL)(load().address("tendon_mj_solve_flow"))


def solve_flow(segments, guides, dragged=False, given=False):
    """The compiled solver; whether it found the solution."""
    return _solve(segments.ctypes.data, guides.ctypes.data, len(guides), dragged, given)


def tendon(lengths, strains, bends, mu_s, mu_d, constant=0.0, was=0.0):
    """Segments and guides of a tendon; strains before the step, ``constant`` over EA."""
    lengths, bends = np.asarray(lengths, float), np.asarray(bends, float)
    segments = new_segments(len(lengths))
    guides = new_guides(len(bends))
    segments["length"] = lengths
    segments["stored"] = lengths / (1.0 + np.asarray(strains, float))
    segments["tension"] = np.maximum(strains, 0.0)
    segments["strain_slope"] = 1.0
    guides["static_ratio"], guides["dynamic_ratio"] = np.exp(mu_s * bends), np.exp(mu_d * bends)
    for ratio in ("static_ratio", "dynamic_ratio"):
        guides[f"{ratio}_back"] = guides[ratio]
    guides["constant_friction"], guides["previous_slip"] = constant, was
    return segments, guides


def uniform(guides, exponent, strain=1e-3, length=0.5):
    """A tendon evenly bent: ``guides`` guides that together hold a ratio e^exponent."""
    lengths = np.full(guides + 1, length / guides)
    lengths[[0, -1]] /= 2.0
    bends = np.full(guides, exponent / guides)
    return tendon(lengths, np.full(guides + 1, strain), bends, 1.0, 1.0)


def commit(segments, guides):
    """Let the flow of the step pass, as the engine does at its end."""
    flow = np.concatenate([[0.0], guides["flow"], [0.0]])
    segments["stored"] += np.diff(flow)
    guides["previous_slip"] = np.where(guides["flow"] != 0.0, guides["slip"], 0.0)


@some.composite
def random_tendons(draw, slack=True, constant=True, most=10):
    """Any tendon in any state before a step."""
    n = draw(some.integers(1, most))
    rng = np.random.default_rng(draw(some.integers(0, 2**32 - 1)))
    lengths = 10.0 ** rng.uniform(-3, 0, n + 1)
    scale = 10.0 ** draw(some.integers(-4, -1))
    low = -1.0 if slack and draw(some.booleans()) else 0.05
    strains = scale * rng.uniform(low, 1.0, n + 1)
    bends = rng.uniform(0.0, 1.5, n) * (rng.random(n) < 0.9)
    mu_d = draw(some.sampled_from([0.0, 0.05, 0.15, 0.5, 1.0]))
    mu_s = mu_d * draw(some.sampled_from([1.0, 1.0, 1.2, 2.0])) + draw(
        some.sampled_from([0.0, 0.0, 0.1])
    )
    rubs = scale * draw(some.sampled_from([0.0, 0.0, 0.01, 0.1])) / n if constant else 0.0
    was = rng.integers(-1, 2, n).astype(float) * draw(some.integers(0, 1))
    return tendon(lengths, strains, bends, mu_s, mu_d, rubs, was)


def wound_over_touching_guides(n, rng):
    """A taut tendon of which up to 1 mm is wound up over an inner guide next to the motor.

    The first segment and others have a length of 1e-9 m, as between a guide and a geom that the
    tendon does not touch.
    """
    lengths = rng.uniform(0.1, 0.7, n + 1)
    lengths[1:-1][rng.random(n - 1) < 0.3] = 1e-9
    lengths[0] = 1e-9
    strain = rng.choice([1e-3, 4e-3, 1e-2])
    strains = strain + 1e-8 * rng.normal(size=n + 1) * (lengths > 1e-9)
    bends = rng.uniform(0.0, 3.0, n) * (rng.random(n) < 0.6)
    segments, guides = tendon(lengths, strains, bends, rng.choice([0.2, 0.4]), 0.2)
    segments["stored"][0] -= rng.uniform(0.0, 1e-3)
    return segments, guides


def drawn_tight_at_its_output(n, rng):
    """A slack tendon that is evenly bent, and of which as much or more is taken out at its end."""
    strain, bends = 10.0 ** rng.uniform(-5.0, -3.0), np.full(n, rng.uniform(0.0, 3.0) / n)
    lengths, constant = np.full(n + 1, 1.0 / n), strain * 10.0 ** rng.uniform(-3.0, 0.0) / n
    segments, guides = tendon(lengths, np.full(n + 1, -strain), bends, 1.0, 1.0, constant)
    slack = (segments["stored"] - segments["length"]).sum()
    segments["stored"][-1] -= min(rng.uniform(1.0, 3.0) * slack, 0.5 / n)
    return segments, guides
