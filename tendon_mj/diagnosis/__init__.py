"""Diagnosis of a model: finds what it lacks against measured data, names it and proves it.

``diagnose`` is the workflow; `CATALOGUE` holds the effects that it can name, beside which an
`Effect` of one's own can be given, bound to a model by ``on_joints`` and its like.
"""

from tendon_mj.diagnosis.before_after import BeforeAfter, write_before_after
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
from tendon_mj.diagnosis.locate import Bin, Located
from tendon_mj.diagnosis.result.diagnosis import Diagnosis, Finding, Value
from tendon_mj.diagnosis.result.error_reduction import ErrorReduction
from tendon_mj.diagnosis.result.ranked import Ranked
from tendon_mj.diagnosis.sysid import SysidResult, fit_with_sysid, sysid_is_there

__all__ = [
    "CATALOGUE",
    "BeforeAfter",
    "Bin",
    "Candidate",
    "Diagnosis",
    "Effect",
    "ErrorReduction",
    "Finding",
    "Located",
    "ParameterSpecification",
    "Ranked",
    "SysidResult",
    "SystemDescription",
    "Term",
    "Value",
    "diagnose",
    "fit_with_sysid",
    "on_gravity",
    "on_inputs",
    "on_joints",
    "on_sensors",
    "on_sheaths",
    "sysid_is_there",
    "together",
    "write_before_after",
]
