"""Simulation of a recording: schedule of controls, parameters, sensor readings, rollouts."""

from tendon_mj.replay.default_motion import Drive as Drive
from tendon_mj.replay.default_motion import default_motion as default_motion
from tendon_mj.replay.frames import FrameRecorder as FrameRecorder
from tendon_mj.replay.frames import Frames as Frames
from tendon_mj.replay.frames import record_frames as record_frames
from tendon_mj.replay.misfit import Misfit as Misfit
from tendon_mj.replay.misfit import replay_error as replay_error
from tendon_mj.replay.parameters import Adjustable as Adjustable
from tendon_mj.replay.parameters import Parameter as Parameter
from tendon_mj.replay.patch import patch_model as patch_model
from tendon_mj.replay.patch import read_intervals as read_intervals
from tendon_mj.replay.replay_recording import replay_recording as replay_recording
from tendon_mj.replay.rollout import full_state as full_state
from tendon_mj.replay.rollout import rollout_named_sensors as rollout_named_sensors
from tendon_mj.replay.rollout import rollout_sensors as rollout_sensors
from tendon_mj.replay.simulator import Simulator as Simulator
from tendon_mj.replay.simulator_protocol import Simulates as Simulates
