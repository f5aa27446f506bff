"""Verification: the bench in MuJoCo against the closed form, and the cost of a step."""

from tendon_mj.verification.comparison import Comparison as Comparison
from tendon_mj.verification.comparison import compare_bench as compare_bench
from tendon_mj.verification.comparison import slow_loop as slow_loop
from tendon_mj.verification.controls import smooth_controls as smooth_controls
from tendon_mj.verification.first_motion import BenchReadings as BenchReadings
from tendon_mj.verification.first_motion import FirstMotion as FirstMotion
from tendon_mj.verification.first_motion import first_motion as first_motion
from tendon_mj.verification.first_motion import run_bench as run_bench
from tendon_mj.verification.step_cost import StepCost as StepCost
from tendon_mj.verification.step_cost import bench_step_cost as bench_step_cost
from tendon_mj.verification.step_cost import finger_step_cost as finger_step_cost
from tendon_mj.verification.stiffness_limit import largest_stiffness as largest_stiffness
