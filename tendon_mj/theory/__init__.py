"""Closed form of a tendon in a frictional sheath, NumPy only (Kaneko et al. 1991).

First motion, outer branches: ``stiffness``, ``first_motion``; any history: ``history``. Units are
SI; ξ is positive toward the actuator and λ is positive while pulling. Equations: docs/theory.md.
"""

from tendon_mj.theory.first_motion import elongation_profile as elongation_profile
from tendon_mj.theory.first_motion import first_displacement as first_displacement
from tendon_mj.theory.first_motion import first_input_tension as first_input_tension
from tendon_mj.theory.first_motion import first_output_tension as first_output_tension
from tendon_mj.theory.first_motion import sliding_length as sliding_length
from tendon_mj.theory.first_motion import tension_profile as tension_profile
from tendon_mj.theory.history import TensionMemory as TensionMemory
from tendon_mj.theory.history import displacement as displacement
from tendon_mj.theory.history import driven_tensions as driven_tensions
from tendon_mj.theory.history import output_tension as output_tension
from tendon_mj.theory.stiffness import apparent_stiffness as apparent_stiffness
from tendon_mj.theory.stiffness import equivalent_backlash as equivalent_backlash
from tendon_mj.theory.stiffness import friction_exponent as friction_exponent
from tendon_mj.theory.stiffness import reversal_backlash as reversal_backlash
from tendon_mj.theory.stiffness import series_stiffness as series_stiffness
from tendon_mj.theory.stiffness import tendon_stiffness as tendon_stiffness
from tendon_mj.theory.stiffness import transmission_stiffness as transmission_stiffness
