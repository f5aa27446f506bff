"""Parameter sweeps: rollouts of a motion, recording or policy over grids and random draws."""

from tendon_mj.lab.sweep.design import SensorSummary as SensorSummary
from tendon_mj.lab.sweep.design import bins_of as bins_of
from tendon_mj.lab.sweep.rollouts import Policy as Policy
from tendon_mj.lab.sweep.rollouts import motion_recording as motion_recording
from tendon_mj.lab.sweep.rollouts import read_policy as read_policy
from tendon_mj.lab.sweep.sweep import CSV as CSV
from tendon_mj.lab.sweep.sweep import PLAN as PLAN
from tendon_mj.lab.sweep.sweep import TABLE as TABLE
from tendon_mj.lab.sweep.sweep import Sweep as Sweep
from tendon_mj.lab.sweep.sweep import SweepResult as SweepResult
from tendon_mj.lab.sweep.sweep import check_folder as check_folder
from tendon_mj.lab.sweep.sweep import run_sweep as run_sweep
