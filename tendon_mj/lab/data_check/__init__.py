"""Checks of recordings against their model before any fit: times, units, signs, start and drive."""

from tendon_mj.lab.data_check.actuators import play_warnings as play_warnings
from tendon_mj.lab.data_check.check import Checked as Checked
from tendon_mj.lab.data_check.check import check_recording as check_recording
from tendon_mj.lab.data_check.faults import DataWarning as DataWarning
from tendon_mj.lab.data_check.force_signals import FORCES as FORCES
from tendon_mj.lab.data_check.force_signals import doubt_of_signals as doubt_of_signals
from tendon_mj.lab.data_check.force_signals import tells_force as tells_force
from tendon_mj.lab.data_check.times import timing_warnings as timing_warnings
