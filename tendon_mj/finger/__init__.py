"""The finger in motion: trajectories, control, tracking error."""

from tendon_mj.finger.control import rehearse as rehearse
from tendon_mj.finger.trajectories import tap as tap
