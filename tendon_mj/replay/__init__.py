"""Simulation of a recording: schedule of controls, parameters, sensor readings, rollouts."""

from tendon_mj.replay.default_motion import Drive as Drive
from tendon_mj.replay.default_motion import default_motion as default_motion
from tendon_mj.replay.replay import replay as replay
from tendon_mj.replay.rollout import full_state as full_state
from tendon_mj.replay.rollout import roll as roll
from tendon_mj.replay.rollout import roll_sensors as roll_sensors
from tendon_mj.replay.simulator import Simulator as Simulator
