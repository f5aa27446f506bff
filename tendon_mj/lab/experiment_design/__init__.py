"""The next experiment: where explanations tie, the one in which they differ most against noise."""

from tendon_mj.lab.experiment_design.experiment import DriveBounds as DriveBounds
from tendon_mj.lab.experiment_design.experiment import Experiment as Experiment
from tendon_mj.lab.experiment_design.experiment import ExperimentBounds as ExperimentBounds
from tendon_mj.lab.experiment_design.experiment import check_bounds as check_bounds
from tendon_mj.lab.experiment_design.experiment import draw_experiment as draw_experiment
from tendon_mj.lab.experiment_design.experiment import planned_recording as planned_recording
from tendon_mj.lab.experiment_design.experiment import read_bounds as read_bounds
from tendon_mj.lab.experiment_design.suggest import Suggestion as Suggestion
from tendon_mj.lab.experiment_design.suggest import suggest_experiment as suggest_experiment
