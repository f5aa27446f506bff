"""Fleets: many rigs of one kind, recorded over days; which one changed, and which one differs.

`find_rigs` → `run_fleet` → `FleetFound`: each rig is observed (`observation`), its changes are
searched for (`changes`) and fitted day by day (`series`), and its numbers compared (`comparison`).
"""

from tendon_mj.lab.fleet.result import FleetFound as FleetFound
from tendon_mj.lab.fleet.result import RigFound as RigFound
from tendon_mj.lab.fleet.rigs import RESULT_TABLE as RESULT_TABLE
from tendon_mj.lab.fleet.rigs import Rig as Rig
from tendon_mj.lab.fleet.rigs import find_rigs as find_rigs
from tendon_mj.lab.fleet.run import run_fleet as run_fleet
