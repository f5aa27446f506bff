"""Cases of a suite: every combination asked for, in random order."""

from __future__ import annotations

import itertools
from collections.abc import Collection

import numpy as np

from experiments.hidden_effects.effects.bench_effects import EFFECTS, EXCLUDABLE, INTERCHANGEABLE
from experiments.hidden_effects.effects.disturbances import DISTURBANCES
from experiments.hidden_effects.effects.joint_effects import JOINT_EFFECTS
from experiments.hidden_effects.effects.wrong_numbers import PARAMETERS
from experiments.hidden_effects.suite.case_plan import CasePlan

KINDS = ("effect", "pair", "parameter", "nothing", "outside", "joint")

SINGLE_EFFECTS = (*EFFECTS, "sheath_friction")


def plan_suite(
    seed: int,
    kinds: Collection[str],
    strengths: Collection[float],
    noises: Collection[float],
    repeats: int,
    nothing: int,
    pairs: int,
) -> list[CasePlan]:
    """Plans of all cases, in random order, so that a case's number does not reveal its kind.

    Args:
        seed: of the order, of the pairs and of every case.
        kinds: some of ``KINDS``.
        strengths: ratios of residual to noise, of cases with one effect [-].
        noises: standard deviations over the range of the signal [-].
        repeats: of cases with one effect, a wrong parameter or an effect outside the catalogue.
        nothing: cases in which nothing is hidden.
        pairs: cases with two effects.
    """
    rng = np.random.default_rng([seed, 0])
    raw: list[tuple[str, tuple[str, ...], float, float, tuple[str, ...]]] = []
    for noise, _ in itertools.product(noises, range(repeats)):
        if "effect" in kinds:
            raw += [("effect", (e,), s, noise, ()) for e in SINGLE_EFFECTS for s in strengths]
        if "joint" in kinds:
            raw += [("joint", (e,), s, noise, ()) for e in JOINT_EFFECTS for s in strengths]
        if "parameter" in kinds:
            raw += [("parameter", (p,), 10.0, noise, ()) for p in PARAMETERS]
        if "outside" in kinds:
            raw += [("outside", (e,), 10.0, noise, _without(e)) for e in EXCLUDABLE]
            raw += [("outside", (e,), 10.0, noise, ()) for e in DISTURBANCES]
    choice = sorted(noises)
    if "nothing" in kinds:
        raw += [("nothing", (), 0.0, choice[k % len(choice)], ()) for k in range(nothing)]
    if "pair" in kinds:
        all_pairs = [p for p in itertools.combinations(EFFECTS, 2) if set(p) not in INTERCHANGEABLE]
        picked = rng.permutation(len(all_pairs))
        for k in range(pairs):
            pair = all_pairs[picked[k % len(picked)]]
            raw.append(("pair", pair, 10.0, choice[k % len(choice)], ()))
    order = rng.permutation(len(raw))
    return [
        CasePlan(
            kind=kind, names=names, target=target, noise=noise, exclude=exclude, seed=(seed, 1 + k)
        )
        for k, (kind, names, target, noise, exclude) in enumerate(raw[i] for i in order)
    ]


def _without(effect: str) -> tuple[str, ...]:
    """The effect and all that can imitate it."""
    same: set[str] = {effect}.union(*(group for group in INTERCHANGEABLE if effect in group))
    return tuple(sorted(same))
