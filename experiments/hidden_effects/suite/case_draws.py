"""Random draws of a case: its effects and true parameters, and the values stated as known."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.hidden_effects.effects.bench_effects import EFFECTS, SHEATH_FRICTION
from experiments.hidden_effects.effects.disturbances import DISTURBANCES
from experiments.hidden_effects.effects.draws import Draw
from experiments.hidden_effects.effects.wrong_numbers import PARAMETERS
from experiments.hidden_effects.references.bench import ReferenceBench
from experiments.hidden_effects.references.joint import ReferenceJoint
from experiments.hidden_effects.suite.case_plan import CasePlan


def draw_effect(kind: str, name: str) -> Draw:
    """Catalogue entry of an effect, parameter or disturbance, by the kind of the case."""
    if name == "sheath_friction":
        return SHEATH_FRICTION
    if kind == "parameter":
        return PARAMETERS[name]
    return (EFFECTS | DISTURBANCES)[name]


def draw_parameters(
    reference: type[ReferenceBench] | type[ReferenceJoint], rng: np.random.Generator
) -> dict[str, Any]:
    """True values of the uncertain attributes, uniform within their ranges."""
    true_ranges = reference.description.true_ranges
    return {name: float(rng.uniform(*span)) for name, span in true_ranges.items()}


def draw_bench(plan: CasePlan, rng: np.random.Generator) -> tuple[ReferenceBench, tuple[str, ...]]:
    """The bench without effects, and its attributes that recordings state as uncertain."""
    drawn = draw_parameters(ReferenceBench, rng)
    if plan.names == ("sheath_friction",):
        return ReferenceBench(friction=0.0, pretension=drawn["pretension"]), ("pretension",)
    uncertain = list(drawn)
    if plan.kind == "parameter":
        wrong = plan.names[0]
        # of friction and bend angle, the data determine the product only
        stated = {"bend_angle": "friction"}.get(wrong, wrong)
        if stated in drawn:
            uncertain.remove(stated)
            drawn[stated] = getattr(ReferenceBench, stated)
    return ReferenceBench(**drawn), tuple(uncertain)


def known_parameters(
    plan: CasePlan, reference: ReferenceBench | ReferenceJoint
) -> dict[str, float]:
    """Parameters that recordings state as known, without any that is wrong or hidden."""
    known = dict(reference.description.known)
    if plan.kind == "parameter":
        known.pop(f"sheath.{plan.names[0]}", None)
    if plan.names in (("sheath_friction",), ("bend_angle",)):
        known["sheath.friction"] = reference.friction
    return known
