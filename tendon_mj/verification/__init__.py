"""The closed form of Kaneko and others (1991) against MuJoCo, and what a step costs."""

from tendon_mj.verification.comparison import slow_loop as slow_loop
from tendon_mj.verification.first_motion import run_bench as run_bench
