"""Cases that have what reality has: sessions that differ, a remainder, numbers too high."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Sequence
from typing import Literal

import numpy as np

from experiments.hidden_effects.effects.bench_effects import (
    EFFECTS,
    EXCLUDABLE,
    OF_FRICTION,
    with_imitators,
)
from experiments.hidden_effects.effects.disturbances import DISTURBANCES
from experiments.hidden_effects.effects.joint_effects import JOINT_EFFECTS
from experiments.hidden_effects.effects.too_high import ON_BENCH, ON_JOINT
from experiments.hidden_effects.suite.case_plan import CasePlan, Kind

TARGET = 5.0  # in units of the reproducibility, or of what small effects and noise leave
# static friction leaves next to no residual, whatever its strength
HIDDEN = (*(e for e in EFFECTS if e != "static_friction"), "sheath_friction")
OF_A_SESSION = "sensor_bias"  # the zeros of sensors are set anew for each session anyway

Rig = Literal["bench", "joint"]


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
        effects: list[tuple[str, Rig]] = [(e, "bench") for e in HIDDEN if e != OF_A_SESSION]
        effects += [(e, "joint") for e in JOINT_EFFECTS]
        for k, ((effect, rig), repeat) in enumerate(itertools.product(effects, range(repeats))):
            plans.append(_session((effect,), rig, noises[0], bends=(k + repeat) % 2 == 1))
        plans += [_session((), "bench", noises[0], bends=k % 2 == 1) for k in range(nothing // 4)]
    if "remainder" in kinds:
        plans += [_remainder(e, noises[0], rng) for e in HIDDEN for _ in range(repeats)]
    if "too_high" in kinds:
        numbers: list[tuple[str, Rig]] = [(name, "bench") for name in ON_BENCH]
        numbers += [(name, "joint") for name in ON_JOINT]
        strong = [s for s in strengths if s >= TARGET] or [TARGET]
        for (name, rig), target, noise, _ in itertools.product(
            numbers, strong, noises, range(repeats)
        ):
            plans.append(_plan("too_high", (name,), rig, noise, target=target))
    return plans


def _session(names: tuple[str, ...], rig: Rig, noise: float, *, bends: bool) -> CasePlan:
    target = TARGET if names else 0.0
    return dataclasses.replace(_plan("session", names, rig, noise, target=target), bends=bends)


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
        _plan("remainder", (effect,), "bench", noise),
        small=tuple(small),
        exclude=tuple(sorted(excluded)),
    )


def _plan(
    kind: Kind, names: tuple[str, ...], rig: Rig, noise: float, *, target: float = TARGET
) -> CasePlan:
    return CasePlan(
        kind=kind, names=names, target=target, noise=noise, exclude=(), seed=(), rig=rig
    )
