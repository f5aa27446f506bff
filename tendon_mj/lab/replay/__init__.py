"""Simulation of recordings and motions.

Schedules of controls, named parameters and patched models, sensor readings, rollouts; motions and
frames for clips; units of columns; and the template of a description.
"""

from tendon_mj.lab.replay.description_template import column_of as column_of
from tendon_mj.lab.replay.description_template import format_template as format_template
from tendon_mj.lab.replay.live_parameters import DRAWN_BEND as DRAWN_BEND
from tendon_mj.lab.replay.live_parameters import EXTRA_BEND as EXTRA_BEND
from tendon_mj.lab.replay.live_parameters import LiveParameters as LiveParameters
from tendon_mj.lab.replay.motion import POSE as POSE
from tendon_mj.lab.replay.motion import Cable as Cable
from tendon_mj.lab.replay.motion import Drive as Drive
from tendon_mj.lab.replay.motion import FrameRecorder as FrameRecorder
from tendon_mj.lab.replay.motion import Frames as Frames
from tendon_mj.lab.replay.motion import check_frames as check_frames
from tendon_mj.lab.replay.motion import default_motion as default_motion
from tendon_mj.lab.replay.motion import frictionless as frictionless
from tendon_mj.lab.replay.motion import read_motion as read_motion
from tendon_mj.lab.replay.motion import record_frames as record_frames
from tendon_mj.lab.replay.names import claims as claims
from tendon_mj.lab.replay.names import expand as expand
from tendon_mj.lab.replay.names import matching as matching
from tendon_mj.lab.replay.names import name_in_session as name_in_session
from tendon_mj.lab.replay.names import parameter_of as parameter_of
from tendon_mj.lab.replay.names import recording_of as recording_of
from tendon_mj.lab.replay.names import value_in as value_in
from tendon_mj.lab.replay.names import values_for as values_for
from tendon_mj.lab.replay.names import values_in as values_in
from tendon_mj.lab.replay.parameters import Adjustable as Adjustable
from tendon_mj.lab.replay.parameters import Kind as Kind
from tendon_mj.lab.replay.parameters import Parameter as Parameter
from tendon_mj.lab.replay.patch import patch_model as patch_model
from tendon_mj.lab.replay.patch import read_intervals as read_intervals
from tendon_mj.lab.replay.readout import Readout as Readout
from tendon_mj.lab.replay.readout import plain_commands as plain_commands
from tendon_mj.lab.replay.schedule import Schedule as Schedule
from tendon_mj.lab.replay.schedule import described_values as described_values
from tendon_mj.lab.replay.schedule import stated_values as stated_values
from tendon_mj.lab.replay.simulation import Misfit as Misfit
from tendon_mj.lab.replay.simulation import ProgressShare as ProgressShare
from tendon_mj.lab.replay.simulation import as_recording as as_recording
from tendon_mj.lab.replay.simulation import full_state as full_state
from tendon_mj.lab.replay.simulation import replay_error as replay_error
from tendon_mj.lab.replay.simulation import replay_recording as replay_recording
from tendon_mj.lab.replay.simulation import rollout_named_sensors as rollout_named_sensors
from tendon_mj.lab.replay.simulation import rollout_sensors as rollout_sensors
from tendon_mj.lab.replay.simulation import suppress_mujoco_log as suppress_mujoco_log
from tendon_mj.lab.replay.simulation import (
    suppress_unsolved_warnings as suppress_unsolved_warnings,
)
from tendon_mj.lab.replay.simulation import try_open_loop as try_open_loop
from tendon_mj.lab.replay.simulation import unsolved_sheaths as unsolved_sheaths
from tendon_mj.lab.replay.simulator import Series as Series
from tendon_mj.lab.replay.simulator import Simulates as Simulates
from tendon_mj.lab.replay.simulator import Simulator as Simulator
from tendon_mj.lab.replay.units import JOINT as JOINT
from tendon_mj.lab.replay.units import UNKNOWN as UNKNOWN
from tendon_mj.lab.replay.units import EngineeringUnit as EngineeringUnit
from tendon_mj.lab.replay.units import column_name as column_name
from tendon_mj.lab.replay.units import column_unit as column_unit
from tendon_mj.lab.replay.units import control_unit as control_unit
from tendon_mj.lab.replay.units import ending_of as ending_of
from tendon_mj.lab.replay.units import engineering_unit as engineering_unit
from tendon_mj.lab.replay.units import estimated_percent as estimated_percent
from tendon_mj.lab.replay.units import from_to as from_to
from tendon_mj.lab.replay.units import percent as percent
from tendon_mj.lab.replay.units import plain as plain
from tendon_mj.lab.replay.units import quantity as quantity
from tendon_mj.lab.replay.units import rate as rate
from tendon_mj.lab.replay.units import reading_unit as reading_unit
from tendon_mj.lab.replay.units import with_unit as with_unit
