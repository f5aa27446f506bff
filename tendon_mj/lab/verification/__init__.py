"""Verification: the bench in MuJoCo against the closed form, and the cost of a step."""

from tendon_mj.lab.verification.comparison import Comparison as Comparison
from tendon_mj.lab.verification.comparison import LargestErrors as LargestErrors
from tendon_mj.lab.verification.comparison import compare_bench as compare_bench
from tendon_mj.lab.verification.comparison import slow_loop as slow_loop
from tendon_mj.lab.verification.controls import smooth_controls as smooth_controls
from tendon_mj.lab.verification.first_motion import SWING as SWING
from tendon_mj.lab.verification.first_motion import BenchReadings as BenchReadings
from tendon_mj.lab.verification.first_motion import FirstMotion as FirstMotion
from tendon_mj.lab.verification.first_motion import first_motion as first_motion
from tendon_mj.lab.verification.first_motion import run_bench as run_bench
from tendon_mj.lab.verification.foreign_model import ModelCost as ModelCost
from tendon_mj.lab.verification.step_cost import StepCost as StepCost
from tendon_mj.lab.verification.step_cost import bench_step_cost as bench_step_cost
from tendon_mj.lab.verification.step_cost import finger_step_cost as finger_step_cost
from tendon_mj.lab.verification.timing import Spread as Spread
