"""Random draws of a case: its effects and true parameters, and the values stated as known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic

import numpy as np

from experiments.hidden_effects.hidden import (
    DISTURBANCES,
    DRAWN,
    EFFECTS,
    JOINT_EFFECTS,
    PARAMETERS,
    SHEATH_FRICTION,
    Draw,
    HiddenEffect,
)
from experiments.hidden_effects.plan import REAL_KINDS, CasePlan
from experiments.hidden_effects.references import (
    SHORT_STEP,
    STEP,
    R,
    ReferenceBench,
    ReferenceJoint,
)
from experiments.hidden_effects.too_high import ON_BENCH, ON_JOINT, TooHigh


@dataclass(frozen=True, kw_only=True)
class CaseDraw(Generic[R]):
    """Hidden content of a case, without the strengths.

    Attributes:
        reference: without the hidden effects.
        hidden: effects, wrong numbers or disturbances.
        small: those that leave the remainder.
        uncertain: attributes of the reference that recordings state as uncertain.
        known: parameters of the model that recordings state as known.
    """

    reference: R
    hidden: tuple[HiddenEffect[R], ...]
    small: tuple[HiddenEffect[R], ...] = ()
    uncertain: tuple[str, ...]
    known: Mapping[str, float]


def draw_joint(plan: CasePlan, rng: np.random.Generator) -> CaseDraw[ReferenceJoint]:
    """Draw a case on the joint."""
    step = SHORT_STEP if plan.kind in REAL_KINDS else STEP
    joint = ReferenceJoint(**draw_parameters(ReferenceJoint, rng), step=step)
    uncertain = _calibrated(plan, joint)
    if plan.kind == "too_high":
        return _too_high(ON_JOINT[plan.names[0]], joint, uncertain, rng)
    return CaseDraw(
        reference=joint,
        hidden=tuple(JOINT_EFFECTS[name](rng) for name in plan.names),
        uncertain=uncertain,
        known=joint.description.known,
    )


def draw_bench(plan: CasePlan, rng: np.random.Generator) -> CaseDraw[ReferenceBench]:
    """Draw a case on the bench."""
    drawn = draw_parameters(ReferenceBench, rng)
    known, wrong = dict(ReferenceBench.description.known), ""
    if plan.names == ("sheath_friction",):
        wrong, drawn["friction"] = "friction", 0.0
    elif plan.kind == "parameter":
        known.pop(f"sheath.{plan.names[0]}", None)
        # of friction and bend angle, the data determine the product only
        wrong = {"bend_angle": "friction"}.get(plan.names[0], plan.names[0])
        if wrong in drawn:
            drawn[wrong] = getattr(ReferenceBench, wrong)
    bench = ReferenceBench(**drawn)
    uncertain = tuple(name for name in _calibrated(plan, bench) if name != wrong)
    if plan.names in (("sheath_friction",), ("bend_angle",)):
        known["sheath.friction"] = bench.friction
    if plan.kind == "too_high":
        return _too_high(ON_BENCH[plan.names[0]], bench, uncertain, rng)
    return CaseDraw(
        reference=bench,
        hidden=tuple(_on_bench(plan.kind, name)(rng) for name in plan.names),
        small=tuple(_on_bench(plan.kind, name)(rng) for name in plan.small),
        uncertain=uncertain,
        known=known,
    )


def draw_parameters(
    reference: type[ReferenceBench] | type[ReferenceJoint], rng: np.random.Generator
) -> dict[str, Any]:
    """True values of the uncertain attributes, uniform within their ranges."""
    true_ranges = reference.description.true_ranges
    return {name: float(rng.uniform(*span)) for name, span in true_ranges.items()}


def _calibrated(plan: CasePlan, reference: ReferenceBench | ReferenceJoint) -> tuple[str, ...]:
    """Attributes that recordings state as uncertain; between sessions the pretension differs."""
    names = reference.description.uncertain
    return tuple(n for n in names if plan.kind != "session" or n != "pretension")


def _on_bench(kind: str, name: str) -> Draw:
    """Draw of an effect, wrong number or disturbance, by the kind of the case."""
    if name == "sheath_friction":
        return SHEATH_FRICTION
    if kind == "parameter":
        return PARAMETERS[name]
    return (EFFECTS | DISTURBANCES | DRAWN)[name]


def _too_high(
    number: TooHigh[R], reference: R, uncertain: tuple[str, ...], rng: np.random.Generator
) -> CaseDraw[R]:
    """A case in which the model's number is above the reference's; recordings do not state it."""
    known = {**reference.description.known, **number.known}
    known.pop(number.parameter, None)
    lower, excess = number.draw(reference, rng)
    return CaseDraw(
        reference=lower,
        hidden=(excess,),
        uncertain=tuple(name for name in uncertain if name != number.name),
        known=known,
    )
