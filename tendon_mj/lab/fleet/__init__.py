"""Fleets: many rigs of one kind, recorded over days; which one changed, and which one differs.

`find_rigs` → `run_fleet` → `FleetResult`: each rig is observed (`observation`), its changes are
searched for (`changes`) and fitted day by day, and its numbers compared (`result`). Two states of
one rig: `compare_states`.
"""

from tendon_mj.lab.fleet.observation import REPRODUCIBILITY as REPRODUCIBILITY
from tendon_mj.lab.fleet.result import FleetResult as FleetResult
from tendon_mj.lab.fleet.result import RigResult as RigResult
from tendon_mj.lab.fleet.rigs import RESULT_TABLE as RESULT_TABLE
from tendon_mj.lab.fleet.rigs import find_rigs as find_rigs
from tendon_mj.lab.fleet.run import run_fleet as run_fleet
from tendon_mj.lab.fleet.states import compare_states as compare_states
