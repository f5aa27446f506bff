"""Recordings: a table of measured columns with a description of what they are."""

from tendon_mj.recordings.description import Measured as Measured
from tendon_mj.recordings.description import Session as Session
from tendon_mj.recordings.description import Uncertain as Uncertain
from tendon_mj.recordings.noise import noise_levels as noise_levels
from tendon_mj.recordings.recording import Recording as Recording
from tendon_mj.recordings.recording import read_recording as read_recording
from tendon_mj.recordings.recording import write_recording as write_recording
from tendon_mj.recordings.table_file import read_table as read_table
