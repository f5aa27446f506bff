"""A model with other parameters in it, written as MJCF, and held against what was meant."""

from tendon_mj.lab.replay.patch.patch_model import patch_model as patch_model
from tendon_mj.lab.replay.patch.patch_model import read_intervals as read_intervals
