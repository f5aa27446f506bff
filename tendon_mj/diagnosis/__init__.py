"""Finds what a model lacks against measured data, names it, adds it, and proves it.

``diagnose`` is the workflow; `CATALOGUE` holds the effects that it can name, beside which an
`Effect` of one's own can be given, bound to a model by ``on_joints`` and its like.
"""

from tendon_mj.diagnosis.before_after import BeforeAfter
from tendon_mj.diagnosis.diagnose import diagnose
from tendon_mj.diagnosis.effects.binding import (
    ParameterSpecification,
    on_gravity,
    on_inputs,
    on_joints,
    on_sensors,
    on_sheaths,
    together,
)
from tendon_mj.diagnosis.effects.catalogue import CATALOGUE
from tendon_mj.diagnosis.effects.effect import Candidate, Effect, SystemDescription, Term
from tendon_mj.diagnosis.verdict import Diagnosis, Finding, Ranked, Value

__all__ = [
    "CATALOGUE",
    "BeforeAfter",
    "Candidate",
    "Diagnosis",
    "Effect",
    "Finding",
    "ParameterSpecification",
    "Ranked",
    "SystemDescription",
    "Term",
    "Value",
    "diagnose",
    "on_gravity",
    "on_inputs",
    "on_joints",
    "on_sensors",
    "on_sheaths",
    "together",
]
