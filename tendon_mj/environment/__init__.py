"""dm_control environments on the finger, a friction of its own in every episode."""

from tendon_mj.environment.finger import follow_trajectory as follow_trajectory
from tendon_mj.environment.finger import hold_force as hold_force
from tendon_mj.environment.physics import FingerPhysics as FingerPhysics
from tendon_mj.environment.ranges import Ranges as Ranges
