"""Cases of a suite: every combination asked for, in random order."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection

import numpy as np

from experiments.hidden_effects.effects.bench_effects import (
    DRAWN,
    EFFECTS,
    EXCLUDABLE,
    INTERCHANGEABLE,
    with_imitators,
)
from experiments.hidden_effects.effects.disturbances import DISTURBANCES
from experiments.hidden_effects.effects.joint_effects import JOINT_EFFECTS
from experiments.hidden_effects.effects.wrong_numbers import PARAMETERS
from experiments.hidden_effects.suite.case_plan import CasePlan, Kind
from experiments.hidden_effects.suite.plan_reality import plan_reality

KINDS: tuple[Kind, ...] = ("effect", "pair", "parameter", "nothing", "outside", "joint")

# Not beside those of kind "drawn": they take many times as long, or leave next to no residual.
SLOW = ("static_friction", "velocity_weakening", "tendon_inertia")
SINGLE_EFFECTS = (*EFFECTS, "sheath_friction")


def plan_suite(
    seed: int,
    kinds: Collection[Kind],
    strengths: Collection[float],
    noises: Collection[float],
    repeats: int,
    nothing: int,
    pairs: int,
) -> list[CasePlan]:
    """Plans of all cases, in random order, so that a case's number does not reveal its kind.

    Args:
        seed: of the order, of the pairs and of every case.
        kinds: any of `CasePlan`.
        strengths: ratios of residual to noise, of cases with one effect [-].
        noises: standard deviations over the range of the signal [-].
        repeats: of cases with one effect, a wrong parameter or an effect outside the catalogue, of
            those of ``REAL_KINDS``, and of each effect of kind "drawn"; every other of these has
            a second effect of the lowest of ``strengths`` beside it.
        nothing: cases in which nothing is hidden.
        pairs: cases with two effects.
    """
    rng = np.random.default_rng([seed, 0])
    plans: list[CasePlan] = []
    for noise, _ in itertools.product(noises, range(repeats)):
        if "effect" in kinds:
            plans += [_plan("effect", (e,), s, noise) for e in SINGLE_EFFECTS for s in strengths]
        if "joint" in kinds:
            plans += [
                dataclasses.replace(_plan("joint", (e,), s, noise), rig="joint")
                for e in JOINT_EFFECTS
                for s in strengths
            ]
        if "parameter" in kinds:
            plans += [_plan("parameter", (p,), 10.0, noise) for p in PARAMETERS]
        if "outside" in kinds:
            plans += [
                _plan("outside", (e,), 10.0, noise, tuple(sorted(with_imitators(e))))
                for e in EXCLUDABLE
            ]
            plans += [_plan("outside", (e,), 10.0, noise) for e in DISTURBANCES]
    choice = sorted(noises)
    if "nothing" in kinds:
        plans += [_plan("nothing", (), 0.0, choice[k % len(choice)]) for k in range(nothing)]
    if "pair" in kinds:
        all_pairs = [p for p in itertools.combinations(EFFECTS, 2) if set(p) not in INTERCHANGEABLE]
        picked = rng.permutation(len(all_pairs))
        for k in range(pairs):
            pair = all_pairs[picked[k % len(picked)]]
            plans.append(_plan("pair", pair, 10.0, choice[k % len(choice)]))
    if "drawn" in kinds:
        seen = [e for e in EFFECTS if e not in SLOW]
        for k, name in itertools.product(range(repeats), DRAWN):
            beside = (str(rng.choice(seen)),) if k % 2 else ()
            plans.append(_plan("drawn", (name, *beside), min(strengths), choice[k % len(choice)]))
    plans += plan_reality(kinds, strengths, choice, repeats, nothing, rng)
    order = rng.permutation(len(plans))
    return [dataclasses.replace(plans[i], seed=(seed, 1 + k)) for k, i in enumerate(order)]


def _plan(
    kind: Kind, names: tuple[str, ...], target: float, noise: float, exclude: tuple[str, ...] = ()
) -> CasePlan:
    return CasePlan(kind=kind, names=names, target=target, noise=noise, exclude=exclude, seed=())
