"""Editing of an `MjSpec` or MJCF file: friction, routes, sensors, spools and servos.

Also live parameters and views of the sheaths of a running simulation.
"""

from tendon_mj.attach.attachment import Attached as Attached
from tendon_mj.attach.attachment import Row as Row
from tendon_mj.attach.attachment import attach_friction as attach_friction
from tendon_mj.attach.cable_drive import add_cable_drive as add_cable_drive
from tendon_mj.attach.cable_drive import attach_cable_drives as attach_cable_drives
from tendon_mj.attach.force_servo import add_servo as add_servo
from tendon_mj.attach.friction import add_friction as add_friction
from tendon_mj.attach.friction import remove_friction as remove_friction
from tendon_mj.attach.instances import add_sensor as add_sensor
from tendon_mj.attach.instances import sheaths_by_tendon as sheaths_by_tendon
from tendon_mj.attach.instances import show_tension as show_tension
from tendon_mj.attach.keywords import checked_number as checked_number
from tendon_mj.attach.live import Parameters as Parameters
from tendon_mj.attach.live import view_sheath as view_sheath
from tendon_mj.attach.mjcf import Element as Element
from tendon_mj.attach.mjcf import Mjcf as Mjcf
from tendon_mj.attach.mjcf import check_suffix as check_suffix
from tendon_mj.attach.mjcf import number_text as number_text
from tendon_mj.attach.mjcf import numbers as numbers
from tendon_mj.attach.mjcf import set_first as set_first
from tendon_mj.attach.mjcf import set_gains as set_gains
from tendon_mj.attach.parameter_ranges import ranges as ranges
from tendon_mj.attach.route import add_sites as add_sites
from tendon_mj.attach.route import add_tendon as add_tendon
from tendon_mj.attach.route import arc_points as arc_points
from tendon_mj.attach.route import bent_points as bent_points
from tendon_mj.attach.spool import Spool as Spool
from tendon_mj.attach.stiffness_limit import largest_stiffness as largest_stiffness
