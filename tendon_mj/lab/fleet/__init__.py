"""Fleets: many rigs of one kind, recorded over days; which one changed, and which one differs."""

from tendon_mj.lab.fleet.result import FleetFound as FleetFound
from tendon_mj.lab.fleet.result import RigFound as RigFound
from tendon_mj.lab.fleet.rig import RESULT_TABLE as RESULT_TABLE
from tendon_mj.lab.fleet.rig import Rig as Rig
from tendon_mj.lab.fleet.rig import find_rigs as find_rigs
from tendon_mj.lab.fleet.run_fleet import run_fleet as run_fleet
