"""Parameter sweeps: rollouts of a motion, recording or policy over grids and random draws."""

from tendon_mj.sweep.motion import motion_recording as motion_recording
from tendon_mj.sweep.policy import Policy as Policy
from tendon_mj.sweep.policy import read_policy as read_policy
from tendon_mj.sweep.result import SweepResult as SweepResult
from tendon_mj.sweep.run_sweep import Sweep as Sweep
from tendon_mj.sweep.run_sweep import run_sweep as run_sweep
