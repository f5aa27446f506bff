"""Trajectories of the finger, their control and tracking error; `find_motion` is for any model."""

from tendon_mj.lab.finger.motions import OUT_OF_REACH as OUT_OF_REACH
from tendon_mj.lab.finger.motions import Trajectory as Trajectory
from tendon_mj.lab.finger.motions import check_finger as check_finger
from tendon_mj.lab.finger.motions import clamped as clamped
from tendon_mj.lab.finger.motions import find_motion as find_motion
from tendon_mj.lab.finger.motions import find_trajectory as find_trajectory
from tendon_mj.lab.finger.motions import lasting as lasting
from tendon_mj.lab.finger.motions import motion_names as motion_names
from tendon_mj.lab.finger.motions import prepare_finger as prepare_finger
from tendon_mj.lab.finger.motions import press as press
from tendon_mj.lab.finger.motions import simulate_finger as simulate_finger
from tendon_mj.lab.finger.motions import summarise as summarise
from tendon_mj.lab.finger.motions import tap as tap
from tendon_mj.lab.finger.motions import tracking_error as tracking_error
