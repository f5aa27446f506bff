"""Tendon-sheath friction for MuJoCo.

Importing this package registers the engine plugins `tendon_mj.sheath` and `tendon_mj.servo`, so
that models which use them can be loaded.
"""

from tendon_mj.attach import Parameters as Parameters
from tendon_mj.attach import add_friction as add_friction
from tendon_mj.attach import add_sensor as add_sensor
from tendon_mj.attach import add_servo as add_servo
from tendon_mj.attach import add_sites as add_sites
from tendon_mj.attach import add_tendon as add_tendon
from tendon_mj.attach import arc_points as arc_points
from tendon_mj.engine import register as _register

_register()
