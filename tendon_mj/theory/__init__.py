"""Closed form of a tendon in a frictional sheath, NumPy only (Kaneko et al. 1991).

Outer branches: ``stiffness``; any history, a first motion too: ``history``. Equations:
docs/theory.md. Arguments and results are in SI units, and broadcast:

| argument | symbol | |
|---|---|---|
| lam | λ [–] | friction exponent, positive while pulling; of a history, its sign is ignored |
| input_tension | T_in [N] | above T_0 it pulls, below it loosens |
| pretension | T_0 [N] | uniform before any motion |
| displacement | ξ_in [m] | of the input end, positive toward the actuator |
| axial_stiffness | EA [N] | force per unit strain |
| length | L [m] | of the sheath |
| output_stiffness | k_se [N/m] | of the spring at the output end; ``inf`` (default) holds it |
| environment_stiffness, sensor_stiffness | k_e, k_s [N/m] | its two parts; ``inf``: rigid |

A history has time on axis 0, and is monotone between samples; results of it have shape (time,
broadcast of the rest). An argument out of its range raises InvalidValueError, which names it.
"""

from tendon_mj.theory.dry_friction import frictionloss as frictionloss
from tendon_mj.theory.history import displacement as displacement
from tendon_mj.theory.history import driven_tensions as driven_tensions
from tendon_mj.theory.history import output_tension as output_tension
from tendon_mj.theory.stiffness import apparent_stiffness as apparent_stiffness
from tendon_mj.theory.stiffness import equivalent_backlash as equivalent_backlash
from tendon_mj.theory.stiffness import reversal_backlash as reversal_backlash
from tendon_mj.theory.stiffness import transmission_stiffness as transmission_stiffness
