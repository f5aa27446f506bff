"""Recordings: tables of measured columns with their descriptions."""

from tendon_mj.lab.recordings.description import Measured as Measured
from tendon_mj.lab.recordings.description import Session as Session
from tendon_mj.lab.recordings.description import Uncertain as Uncertain
from tendon_mj.lab.recordings.description import check_keys as check_keys
from tendon_mj.lab.recordings.description import read_entries as read_entries
from tendon_mj.lab.recordings.description import read_number as read_number
from tendon_mj.lab.recordings.files import FORMATS as FORMATS
from tendon_mj.lab.recordings.files import files_in as files_in
from tendon_mj.lab.recordings.files import read_text as read_text
from tendon_mj.lab.recordings.files import read_toml as read_toml
from tendon_mj.lab.recordings.files import table_beside as table_beside
from tendon_mj.lab.recordings.files import tables_in as tables_in
from tendon_mj.lab.recordings.recording import GivenRecording as GivenRecording
from tendon_mj.lab.recordings.recording import Recording as Recording
from tendon_mj.lab.recordings.recording import is_same_model as is_same_model
from tendon_mj.lab.recordings.recording import read_columns as read_columns
from tendon_mj.lab.recordings.recording import read_description as read_description
from tendon_mj.lab.recordings.recording import read_given as read_given
from tendon_mj.lab.recordings.recording import read_recording as read_recording
from tendon_mj.lab.recordings.recording import read_table as read_table
from tendon_mj.lab.recordings.recording import write_recording as write_recording
from tendon_mj.lab.recordings.table import in_si as in_si
