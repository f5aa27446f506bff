"""Verification: the bench in MuJoCo against the closed form, and the cost of a step."""

from tendon_mj.lab.verification.comparison import SWING as SWING
from tendon_mj.lab.verification.comparison import BenchReadings as BenchReadings
from tendon_mj.lab.verification.comparison import Comparison as Comparison
from tendon_mj.lab.verification.comparison import FirstMotion as FirstMotion
from tendon_mj.lab.verification.comparison import LargestErrors as LargestErrors
from tendon_mj.lab.verification.comparison import compare_bench as compare_bench
from tendon_mj.lab.verification.comparison import run_bench as run_bench
from tendon_mj.lab.verification.costs import ModelCost as ModelCost
from tendon_mj.lab.verification.costs import Quartiles as Quartiles
from tendon_mj.lab.verification.costs import StepCost as StepCost
from tendon_mj.lab.verification.costs import TimedRun as TimedRun
from tendon_mj.lab.verification.costs import measure_models as measure_models
from tendon_mj.lab.verification.costs import mujoco_tendon_bench as mujoco_tendon_bench
from tendon_mj.lab.verification.costs import processor_time as processor_time
from tendon_mj.lab.verification.costs import run_along as run_along
from tendon_mj.lab.verification.costs import smooth_controls as smooth_controls
from tendon_mj.lab.verification.costs import step_times as step_times
from tendon_mj.lab.verification.costs import times_in_turns as times_in_turns
from tendon_mj.lab.verification.costs import without_tension_sensors as without_tension_sensors
