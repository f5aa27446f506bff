"""The friction model alone: its law, the flow solver, a bench without MuJoCo."""

from tendon_mj.sheath.bench import Response as Response
from tendon_mj.sheath.bench import drive_displacement as drive_displacement
from tendon_mj.sheath.bench import drive_tension as drive_tension
from tendon_mj.sheath.law import Law as Law
