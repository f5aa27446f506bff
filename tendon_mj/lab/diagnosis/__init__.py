"""Diagnosis of a model: finds what it lacks against measured data, names it and proves it.

``diagnose`` is the workflow; `CATALOGUE` holds the effects that it can name, beside which an
`Effect` of one's own can be given, bound to a model by ``on_joints`` and its like.
"""

from tendon_mj.lab.diagnosis.before_after import BeforeAfter, write_before_after
from tendon_mj.lab.diagnosis.check import check_recordings as check_recordings
from tendon_mj.lab.diagnosis.check import check_simulation as check_simulation
from tendon_mj.lab.diagnosis.correlations import Correlations as Correlations
from tendon_mj.lab.diagnosis.correlations import parameter_correlations as parameter_correlations
from tendon_mj.lab.diagnosis.data.problem import MakeSimulator as MakeSimulator
from tendon_mj.lab.diagnosis.data.problem import Problem as Problem
from tendon_mj.lab.diagnosis.data.problem import all_samples as all_samples
from tendon_mj.lab.diagnosis.data.sessions import Spread as Spread
from tendon_mj.lab.diagnosis.data.sessions import session_terms as session_terms
from tendon_mj.lab.diagnosis.data.step_size import search_step as search_step
from tendon_mj.lab.diagnosis.data.step_size import with_step as with_step
from tendon_mj.lab.diagnosis.data.uncertain import uncertain_terms as uncertain_terms
from tendon_mj.lab.diagnosis.diagnose import describe_system as describe_system
from tendon_mj.lab.diagnosis.diagnose import diagnose
from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    on_gravity,
    on_inputs,
    on_joints,
    on_sensors,
    on_sheaths,
    together,
)
from tendon_mj.lab.diagnosis.effects.catalogue import CATALOGUE
from tendon_mj.lab.diagnosis.effects.catalogue import candidates as candidates
from tendon_mj.lab.diagnosis.effects.discrimination import (
    DISCRIMINATING_EXPERIMENTS as DISCRIMINATING_EXPERIMENTS,
)
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, SystemDescription, Term
from tendon_mj.lab.diagnosis.locate import Bin, Located
from tendon_mj.lab.diagnosis.model_selection.comparison import FittedCandidate as FittedCandidate
from tendon_mj.lab.diagnosis.model_selection.comparison import tied as tied
from tendon_mj.lab.diagnosis.model_selection.confidence import SelectedEffect as SelectedEffect
from tendon_mj.lab.diagnosis.model_selection.context import SelectionContext as SelectionContext
from tendon_mj.lab.diagnosis.model_selection.fit import Fit as Fit
from tendon_mj.lab.diagnosis.model_selection.fit import expected as expected
from tendon_mj.lab.diagnosis.model_selection.fit import fit as fit
from tendon_mj.lab.diagnosis.model_selection.fit import written as written
from tendon_mj.lab.diagnosis.model_selection.intervals import intervals as intervals
from tendon_mj.lab.diagnosis.model_selection.screening import (
    bounded_least_squares as bounded_least_squares,
)
from tendon_mj.lab.diagnosis.model_selection.select import Selection as Selection
from tendon_mj.lab.diagnosis.model_selection.thresholds import SMALLEST_EXCESS as SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.noise_sensitivity import noise_sensitivity as noise_sensitivity
from tendon_mj.lab.diagnosis.provenance import Provenance as Provenance
from tendon_mj.lab.diagnosis.provenance import collect_provenance as collect_provenance
from tendon_mj.lab.diagnosis.provenance import files_of as files_of
from tendon_mj.lab.diagnosis.result.diagnosis import Diagnosis, Finding, Value
from tendon_mj.lab.diagnosis.result.diagnosis import Verdict as Verdict
from tendon_mj.lab.diagnosis.result.error_reduction import ErrorReduction
from tendon_mj.lab.diagnosis.result.ranked import Ranked
from tendon_mj.lab.diagnosis.sysid import SysidResult, fit_with_sysid, sysid_is_there
from tendon_mj.lab.diagnosis.whiteness import Autocorrelation as Autocorrelation
from tendon_mj.lab.diagnosis.whiteness import residual_autocorrelations as residual_autocorrelations

__all__ = [
    "CATALOGUE",
    "DISCRIMINATING_EXPERIMENTS",
    "SMALLEST_EXCESS",
    "Autocorrelation",
    "BeforeAfter",
    "Bin",
    "Candidate",
    "Correlations",
    "Diagnosis",
    "Effect",
    "ErrorReduction",
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
