"""Finds what a model lacks against measured data, names it, adds it, and proves it.

``diagnose`` is the workflow; `CATALOGUE` holds the effects that it can name.
"""

from tendon_mj.diagnosis.catalogue import CATALOGUE
from tendon_mj.diagnosis.diagnose import diagnose
from tendon_mj.diagnosis.effect import Candidate, Effect, Rig, Term
from tendon_mj.diagnosis.verdict import Diagnosis, Finding, Ranked, Value

__all__ = [
    "CATALOGUE",
    "Candidate",
    "Diagnosis",
    "Effect",
    "Finding",
    "Ranked",
    "Rig",
    "Term",
    "Value",
    "diagnose",
]
