"""Diagnosis of a model: finds what it lacks against measured data, names it and proves it.

``diagnose`` is the workflow; `CATALOGUE` holds the effects that it can name.
"""

from tendon_mj.diagnosis.catalogue import CATALOGUE
from tendon_mj.diagnosis.diagnose import diagnose
from tendon_mj.diagnosis.effect import Candidate, Effect, Rig, Term
from tendon_mj.diagnosis.locate import Bin, Located
from tendon_mj.diagnosis.result.diagnosis import Diagnosis, Finding, Ranked, Value
from tendon_mj.diagnosis.result.error_reduction import ErrorReduction
from tendon_mj.diagnosis.sysid import SysidResult, fit_with_sysid, sysid_is_there

__all__ = [
    "CATALOGUE",
    "Bin",
    "Candidate",
    "Diagnosis",
    "Effect",
    "ErrorReduction",
    "Finding",
    "Located",
    "Ranked",
    "Rig",
    "SysidResult",
    "Term",
    "Value",
    "diagnose",
    "fit_with_sysid",
    "sysid_is_there",
]
