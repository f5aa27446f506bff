"""Simulation of recordings and motions.

Schedules of controls, named parameters and patched models, sensor readings, rollouts; motions and
frames for clips; units of columns; and the template of a description.
"""

from tendon_mj.lab.replay.description_template import column_of as column_of
from tendon_mj.lab.replay.description_template import format_template as format_template
from tendon_mj.lab.replay.friction_effect import free_joints as free_joints
from tendon_mj.lab.replay.friction_effect import friction_sentence as friction_sentence
from tendon_mj.lab.replay.friction_effect import most_first as most_first
from tendon_mj.lab.replay.friction_effect import sheathed_tendons as sheathed_tendons
from tendon_mj.lab.replay.motion import POSE as POSE
from tendon_mj.lab.replay.motion import Cable as Cable
from tendon_mj.lab.replay.motion import Drive as Drive
from tendon_mj.lab.replay.motion import FrameRecorder as FrameRecorder
from tendon_mj.lab.replay.motion import Frames as Frames
from tendon_mj.lab.replay.motion import check_frames as check_frames
from tendon_mj.lab.replay.motion import control_limits as control_limits
from tendon_mj.lab.replay.motion import default_motion as default_motion
from tendon_mj.lab.replay.motion import demonstration_time as demonstration_time
from tendon_mj.lab.replay.motion import frictionless as frictionless
from tendon_mj.lab.replay.motion import is_friction as is_friction
from tendon_mj.lab.replay.motion import read_motion as read_motion
from tendon_mj.lab.replay.motion import record_frames as record_frames
from tendon_mj.lab.replay.motion import resting as resting
from tendon_mj.lab.replay.motion import without_range as without_range
from tendon_mj.lab.replay.parameters import DRAWN_BEND as DRAWN_BEND
from tendon_mj.lab.replay.parameters import EXTRA_BEND as EXTRA_BEND
from tendon_mj.lab.replay.parameters import RANGE_WIDTH as RANGE_WIDTH
from tendon_mj.lab.replay.parameters import Adjustable as Adjustable
from tendon_mj.lab.replay.parameters import Kind as Kind
from tendon_mj.lab.replay.parameters import Parameter as Parameter
from tendon_mj.lab.replay.parameters import has_soft_friction as has_soft_friction
from tendon_mj.lab.replay.parameters import stiff_friction as stiff_friction
from tendon_mj.lab.replay.patch import patch_model as patch_model
from tendon_mj.lab.replay.patch import read_intervals as read_intervals
from tendon_mj.lab.replay.play import load_recorded as load_recorded
from tendon_mj.lab.replay.readout import Readout as Readout
from tendon_mj.lab.replay.readout import plain_commands as plain_commands
from tendon_mj.lab.replay.schedule import Schedule as Schedule
from tendon_mj.lab.replay.schedule import described_values as described_values
from tendon_mj.lab.replay.schedule import stated_values as stated_values
from tendon_mj.lab.replay.simulation import Misfit as Misfit
from tendon_mj.lab.replay.simulation import Series as Series
from tendon_mj.lab.replay.simulation import Simulates as Simulates
from tendon_mj.lab.replay.simulation import Simulator as Simulator
from tendon_mj.lab.replay.simulation import as_recording as as_recording
from tendon_mj.lab.replay.simulation import full_state as full_state
from tendon_mj.lab.replay.simulation import replay_error as replay_error
from tendon_mj.lab.replay.simulation import replay_recording as replay_recording
from tendon_mj.lab.replay.simulation import rollout_named_sensors as rollout_named_sensors
from tendon_mj.lab.replay.simulation import rollout_sensors as rollout_sensors
from tendon_mj.lab.replay.simulation import run_open_loop as run_open_loop
from tendon_mj.lab.replay.simulation import suppress_mujoco_log as suppress_mujoco_log
from tendon_mj.lab.replay.simulation import suppress_unsolved_warnings as suppress_unsolved_warnings
from tendon_mj.lab.replay.simulation import unsolved_sheaths as unsolved_sheaths
from tendon_mj.lab.replay.units import control_unit as control_unit
from tendon_mj.lab.replay.units import reading_unit as reading_unit
