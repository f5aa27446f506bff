"""Simulation of recordings.

Schedules of controls, named parameters and patched models, sensor readings, rollouts; and the
template of a description.
"""

from tendon_mj.lab.replay.description_template import column_of as column_of
from tendon_mj.lab.replay.description_template import format_template as format_template
from tendon_mj.lab.replay.parameters import DRAWN_BEND as DRAWN_BEND
from tendon_mj.lab.replay.parameters import EXTRA_BEND as EXTRA_BEND
from tendon_mj.lab.replay.parameters import GEARED as GEARED
from tendon_mj.lab.replay.parameters import RANGE_WIDTH as RANGE_WIDTH
from tendon_mj.lab.replay.parameters import Adjustable as Adjustable
from tendon_mj.lab.replay.parameters import Kind as Kind
from tendon_mj.lab.replay.parameters import Parameter as Parameter
from tendon_mj.lab.replay.parameters import has_soft_friction as has_soft_friction
from tendon_mj.lab.replay.parameters import stiff_friction as stiff_friction
from tendon_mj.lab.replay.patch import patch_model as patch_model
from tendon_mj.lab.replay.patch import read_intervals as read_intervals
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
from tendon_mj.lab.replay.simulation import load_recorded as load_recorded
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
