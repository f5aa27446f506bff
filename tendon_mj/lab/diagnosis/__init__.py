"""Diagnosis of a model against measured data: finds the effects that it lacks, and proves them.

`diagnose` is the workflow; `CATALOGUE` holds the effects that it can name. A user's own `Effect`
is bound to a model by `on_joints` and its like.
"""

from tendon_mj.lab.diagnosis.audit import Autocorrelation as Autocorrelation
from tendon_mj.lab.diagnosis.audit import Correlations as Correlations
from tendon_mj.lab.diagnosis.audit import Provenance as Provenance
from tendon_mj.lab.diagnosis.audit import collect_provenance as collect_provenance
from tendon_mj.lab.diagnosis.audit import files_of as files_of
from tendon_mj.lab.diagnosis.audit import noise_sensitivity as noise_sensitivity
from tendon_mj.lab.diagnosis.audit import parameter_correlations as parameter_correlations
from tendon_mj.lab.diagnosis.audit import residual_autocorrelations as residual_autocorrelations
from tendon_mj.lab.diagnosis.check import check_recordings as check_recordings
from tendon_mj.lab.diagnosis.check import check_simulation as check_simulation
from tendon_mj.lab.diagnosis.data import MakeSimulator as MakeSimulator
from tendon_mj.lab.diagnosis.data import Problem as Problem
from tendon_mj.lab.diagnosis.data import all_samples as all_samples
from tendon_mj.lab.diagnosis.data import describe_system as describe_system
from tendon_mj.lab.diagnosis.data import search_step as search_step
from tendon_mj.lab.diagnosis.data import session_terms as session_terms
from tendon_mj.lab.diagnosis.data import uncertain_terms as uncertain_terms
from tendon_mj.lab.diagnosis.data import with_step as with_step
from tendon_mj.lab.diagnosis.effects import CATALOGUE as CATALOGUE
from tendon_mj.lab.diagnosis.effects import DISCRIMINATING_EXPERIMENTS as DISCRIMINATING_EXPERIMENTS
from tendon_mj.lab.diagnosis.effects import candidates as candidates
from tendon_mj.lab.diagnosis.effects.binding import ParameterSpecification as ParameterSpecification
from tendon_mj.lab.diagnosis.effects.binding import on_inputs as on_inputs
from tendon_mj.lab.diagnosis.effects.binding import on_joints as on_joints
from tendon_mj.lab.diagnosis.effects.binding import on_sensors as on_sensors
from tendon_mj.lab.diagnosis.effects.binding import on_sheaths as on_sheaths
from tendon_mj.lab.diagnosis.effects.effect import Candidate as Candidate
from tendon_mj.lab.diagnosis.effects.effect import Effect as Effect
from tendon_mj.lab.diagnosis.effects.effect import SystemDescription as SystemDescription
from tendon_mj.lab.diagnosis.effects.effect import Term as Term
from tendon_mj.lab.diagnosis.fitting import DIFFERENCE as DIFFERENCE
from tendon_mj.lab.diagnosis.fitting import Fit as Fit
from tendon_mj.lab.diagnosis.fitting import bounded_least_squares as bounded_least_squares
from tendon_mj.lab.diagnosis.fitting import expected as expected
from tendon_mj.lab.diagnosis.fitting import fit as fit
from tendon_mj.lab.diagnosis.fitting import written as written
from tendon_mj.lab.diagnosis.regimes import Bin as Bin
from tendon_mj.lab.diagnosis.regimes import Located as Located
from tendon_mj.lab.diagnosis.rehearsal import rehearse as rehearse
from tendon_mj.lab.diagnosis.result import BeforeAfter as BeforeAfter
from tendon_mj.lab.diagnosis.result import Diagnosis as Diagnosis
from tendon_mj.lab.diagnosis.result import Finding as Finding
from tendon_mj.lab.diagnosis.result import Value as Value
from tendon_mj.lab.diagnosis.result import write_before_after as write_before_after
from tendon_mj.lab.diagnosis.selection import CONVERGED as CONVERGED
from tendon_mj.lab.diagnosis.selection import Selection as Selection
from tendon_mj.lab.diagnosis.selection import SelectionContext as SelectionContext
from tendon_mj.lab.diagnosis.statistics import FittedCandidate as FittedCandidate
from tendon_mj.lab.diagnosis.statistics import SelectedEffect as SelectedEffect
from tendon_mj.lab.diagnosis.statistics import intervals as intervals
from tendon_mj.lab.diagnosis.statistics import tied as tied
from tendon_mj.lab.diagnosis.sysid import SysidResult as SysidResult
from tendon_mj.lab.diagnosis.sysid import fit_with_sysid as fit_with_sysid
from tendon_mj.lab.diagnosis.sysid import sysid_is_there as sysid_is_there
from tendon_mj.lab.diagnosis.verdict import SMALLEST_EXCESS as SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.verdict import STANDARD_ERRORS as STANDARD_ERRORS
from tendon_mj.lab.diagnosis.verdict import ErrorReduction as ErrorReduction
from tendon_mj.lab.diagnosis.wording import MEANING as MEANING
from tendon_mj.lab.diagnosis.wording import state_alternatives as state_alternatives
from tendon_mj.lab.diagnosis.workflow import diagnose as diagnose
