"""Plans of hidden cases: every combination asked for, in random order."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from experiments.hidden_effects.hidden import (
    DISTURBANCES,
    DRAWN,
    EFFECTS,
    EXCLUDABLE,
    INTERCHANGEABLE,
    JOINT_EFFECTS,
    OF_FRICTION,
    PARAMETERS,
    with_imitators,
)
from experiments.hidden_effects.too_high import ON_BENCH, ON_JOINT

Rig = Literal["bench", "joint"]
Kind = Literal[
    "effect",
    "pair",
    "parameter",
    "nothing",
    "outside",
    "joint",
    "session",
    "remainder",
    "too_high",
    "drawn",
]
# As on real rigs; each of these cases has its own model beside its recordings.
REAL_KINDS = ("session", "remainder", "too_high")
KINDS: tuple[Kind, ...] = ("effect", "pair", "parameter", "nothing", "outside", "joint")
# Not beside those of kind "drawn": they take many times as long, or leave next to no residual.
SLOW = ("static_friction", "velocity_weakening", "tendon_inertia")
SINGLE_EFFECTS = (*EFFECTS, "sheath_friction")
TARGET = 5.0  # in units of the reproducibility, or of the rms of small effects and noise
# static friction leaves next to no residual, whatever its strength
HIDDEN = (*(e for e in EFFECTS if e != "static_friction"), "sheath_friction")
OF_A_SESSION = "sensor_bias"  # the zeros of sensors are set anew for each session anyway


@dataclass(frozen=True, kw_only=True)
class CasePlan:
    """Content of a case, before anything is drawn.

    Attributes:
        kind: of the case.
        names: of the hidden effects, wrong numbers or disturbances.
        target: wanted ratio of residual to noise, for each of them [-]; of kind "session" to the
            reproducibility, of kind "remainder" to the small effects' residual. Of kind "drawn" it
            is that of the second effect, and the strength of the first is drawn.
        noise: standard deviation over the range of each measured column [-].
        exclude: effects to take out of the catalogue when diagnosing.
        seed: of every random draw.
        rig: that the case is of.
        small: names of the effects that leave the remainder.
        bends: whether the sheath's bend differs between the recordings.
    """

    kind: Kind
    names: tuple[str, ...]
    target: float
    noise: float
    exclude: tuple[str, ...]
    seed: tuple[int, ...]
    rig: Rig = "bench"
    small: tuple[str, ...] = ()
    bends: bool = False


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
        plans += _one_of_each(kinds, strengths, noise)
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
            second = (str(rng.choice(seen)),) if k % 2 else ()
            plans.append(_plan("drawn", (name, *second), min(strengths), choice[k % len(choice)]))
    plans += plan_reality(kinds, strengths, choice, repeats, nothing, rng)
    order = rng.permutation(len(plans))
    return [dataclasses.replace(plans[i], seed=(seed, 1 + k)) for k, i in enumerate(order)]


def _one_of_each(
    kinds: Collection[Kind], strengths: Collection[float], noise: float
) -> list[CasePlan]:
    """Every effect at every strength, every wrong number, every effect outside the catalogue."""
    plans: list[CasePlan] = []
    if "effect" in kinds:
        plans += [_plan("effect", (e,), s, noise) for e in SINGLE_EFFECTS for s in strengths]
    if "joint" in kinds:
        plans += [
            _plan("joint", (e,), s, noise, rig="joint") for e in JOINT_EFFECTS for s in strengths
        ]
    if "parameter" in kinds:
        plans += [_plan("parameter", (p,), 10.0, noise) for p in PARAMETERS]
    if "outside" in kinds:
        for e in EXCLUDABLE:
            exclude = tuple(sorted(with_imitators(e)))
            plans.append(_plan("outside", (e,), 10.0, noise, exclude=exclude))
        plans += [_plan("outside", (e,), 10.0, noise) for e in DISTURBANCES]
    return plans


def _plan(
    kind: Kind,
    names: tuple[str, ...],
    target: float,
    noise: float,
    *,
    rig: Rig = "bench",
    exclude: tuple[str, ...] = (),
) -> CasePlan:
    return CasePlan(
        kind=kind, names=names, target=target, noise=noise, exclude=exclude, seed=(), rig=rig
    )


def plan_reality(
    kinds: Collection[Kind],
    strengths: Collection[float],
    noises: Sequence[float],
    repeats: int,
    nothing: int,
    rng: np.random.Generator,
) -> list[CasePlan]:
    """Plans of the kinds "session", "remainder" and "too_high"; arguments as of `plan_suite`.

    With sessions and remainders the noise is the smallest: five times what they leave would
    otherwise be more than most effects can do. A quarter as many sessions as ``nothing`` hide
    nothing; in every other session the bend of the sheath differs between the recordings.
    """
    plans: list[CasePlan] = []
    if "session" in kinds:
        plans += _sessions(noises[0], repeats)
        plans += [_session((), "bench", noises[0], bends=k % 2 == 1) for k in range(nothing // 4)]
    if "remainder" in kinds:
        plans += [_remainder(e, noises[0], rng) for e in HIDDEN for _ in range(repeats)]
    if "too_high" in kinds:
        strong = [s for s in strengths if s >= TARGET] or [TARGET]
        numbers: list[tuple[str, Rig]] = [(name, "bench") for name in ON_BENCH]
        numbers += [(name, "joint") for name in ON_JOINT]
        each = itertools.product(numbers, strong, noises, range(repeats))
        plans += [
            _plan("too_high", (name,), s, noise, rig=rig) for (name, rig), s, noise, _ in each
        ]
    return plans


def _sessions(noise: float, repeats: int) -> list[CasePlan]:
    effects: list[tuple[str, Rig]] = [(e, "bench") for e in HIDDEN if e != OF_A_SESSION]
    effects += [(e, "joint") for e in JOINT_EFFECTS]
    return [
        _session((effect,), rig, noise, bends=(k + repeat) % 2 == 1)
        for k, ((effect, rig), repeat) in enumerate(itertools.product(effects, range(repeats)))
    ]


def _session(names: tuple[str, ...], rig: Rig, noise: float, *, bends: bool) -> CasePlan:
    target = TARGET if names else 0.0
    return dataclasses.replace(_plan("session", names, target, noise, rig=rig), bends=bends)


def _remainder(effect: str, noise: float, rng: np.random.Generator) -> CasePlan:
    """An effect above two small ones, none of which can imitate another."""
    small: list[str] = []
    for name in rng.permutation([*EXCLUDABLE, *DISTURBANCES]).tolist():
        without_place = effect == "sheath_friction" and name in OF_FRICTION
        if not without_place and not with_imitators(name) & {effect, *small}:
            small.append(name)
    small = small[:2]
    excluded = set[str]().union(*(with_imitators(name) for name in small if name in EXCLUDABLE))
    return dataclasses.replace(
        _plan("remainder", (effect,), TARGET, noise),
        small=tuple(small),
        exclude=tuple(sorted(excluded)),
    )
