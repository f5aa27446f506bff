"""Diagnosis of a model against measured data: finds the effects that it lacks, and proves them.

`diagnose` is the workflow; `CATALOGUE` holds the effects that it can name. A user's own `Effect`
is bound to a model by `on_joints` and its like.
"""

from tendon_mj.lab.diagnosis.audit import (
    Autocorrelation,
    Correlations,
    Provenance,
    collect_provenance,
    files_of,
    noise_sensitivity,
    parameter_correlations,
    residual_autocorrelations,
)
from tendon_mj.lab.diagnosis.check import check_recordings, check_simulation
from tendon_mj.lab.diagnosis.data import (
    MakeSimulator,
    Problem,
    Spread,
    all_samples,
    describe_system,
    search_step,
    session_terms,
    uncertain_terms,
    with_step,
)
from tendon_mj.lab.diagnosis.effects import CATALOGUE, DISCRIMINATING_EXPERIMENTS, candidates
from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    on_gravity,
    on_inputs,
    on_joints,
    on_sensors,
    on_sheaths,
    together,
)
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, SystemDescription, Term
from tendon_mj.lab.diagnosis.fitting import Fit, expected, fit, written
from tendon_mj.lab.diagnosis.regimes import Bin, Located
from tendon_mj.lab.diagnosis.result import (
    BeforeAfter,
    Diagnosis,
    Finding,
    Ranked,
    Value,
    write_before_after,
)
from tendon_mj.lab.diagnosis.search import bounded_least_squares
from tendon_mj.lab.diagnosis.selection import Selection, SelectionContext
from tendon_mj.lab.diagnosis.statistics import FittedCandidate, SelectedEffect, intervals, tied
from tendon_mj.lab.diagnosis.sysid import SysidResult, fit_with_sysid, sysid_is_there
from tendon_mj.lab.diagnosis.thresholds import SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.verdict import ErrorReduction, Evidence, Verdict
from tendon_mj.lab.diagnosis.wording import MEANING
from tendon_mj.lab.diagnosis.workflow import diagnose

__all__ = [
    "CATALOGUE",
    "DISCRIMINATING_EXPERIMENTS",
    "MEANING",
    "SMALLEST_EXCESS",
    "Autocorrelation",
    "BeforeAfter",
    "Bin",
    "Candidate",
    "Correlations",
    "Diagnosis",
    "Effect",
    "ErrorReduction",
    "Evidence",
    "Finding",
    "Fit",
    "FittedCandidate",
    "Located",
    "MakeSimulator",
    "ParameterSpecification",
    "Problem",
    "Provenance",
    "Ranked",
    "SelectedEffect",
    "Selection",
    "SelectionContext",
    "Spread",
    "SysidResult",
    "SystemDescription",
    "Term",
    "Value",
    "Verdict",
    "all_samples",
    "bounded_least_squares",
    "candidates",
    "check_recordings",
    "check_simulation",
    "collect_provenance",
    "describe_system",
    "diagnose",
    "expected",
    "files_of",
    "fit",
    "fit_with_sysid",
    "intervals",
    "noise_sensitivity",
    "on_gravity",
    "on_inputs",
    "on_joints",
    "on_sensors",
    "on_sheaths",
    "parameter_correlations",
    "residual_autocorrelations",
    "search_step",
    "session_terms",
    "sysid_is_there",
    "tied",
    "together",
    "uncertain_terms",
    "with_step",
    "write_before_after",
    "written",
]
