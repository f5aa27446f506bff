"""Trajectories of the finger, their control and tracking error; `find_motion` is for any model."""

from tendon_mj.lab.finger.control import OUT_OF_REACH as OUT_OF_REACH
from tendon_mj.lab.finger.control import Motion as Motion
from tendon_mj.lab.finger.control import find_motion as find_motion
from tendon_mj.lab.finger.control import prepare_finger as prepare_finger
from tendon_mj.lab.finger.control import simulate_finger as simulate_finger
from tendon_mj.lab.finger.control import summarise as summarise
from tendon_mj.lab.finger.control import tracking_error as tracking_error
from tendon_mj.lab.finger.trajectories import Trajectory as Trajectory
from tendon_mj.lab.finger.trajectories import clamped as clamped
from tendon_mj.lab.finger.trajectories import curl as curl
from tendon_mj.lab.finger.trajectories import find_trajectory as find_trajectory
from tendon_mj.lab.finger.trajectories import hold as hold
from tendon_mj.lab.finger.trajectories import lasting as lasting
from tendon_mj.lab.finger.trajectories import press as press
from tendon_mj.lab.finger.trajectories import tap as tap
