"""Closed form of a tendon in a frictional sheath, NumPy only (Kaneko et al. 1991).

First motion and outer branches: ``stiffness``, ``profile``, ``transmission``.
Any history: of tension ``play``, of displacement ``drive``, both on ``memory``.
Units are SI; ξ is positive toward the actuator and λ is positive while pulling.

Equations: docs/theory.md, sections 1 and 2.
"""

from tendon_mj.theory.drive import driven_tensions as driven_tensions
from tendon_mj.theory.play_operator import displacement as displacement
from tendon_mj.theory.play_operator import output_tension as output_tension
from tendon_mj.theory.profile import elongation_profile as elongation_profile
from tendon_mj.theory.profile import sliding_length as sliding_length
from tendon_mj.theory.profile import tension_profile as tension_profile
from tendon_mj.theory.stiffness import apparent_stiffness as apparent_stiffness
from tendon_mj.theory.stiffness import equivalent_backlash as equivalent_backlash
from tendon_mj.theory.stiffness import friction_exponent as friction_exponent
from tendon_mj.theory.stiffness import reversal_backlash as reversal_backlash
from tendon_mj.theory.stiffness import series_stiffness as series_stiffness
from tendon_mj.theory.stiffness import tendon_stiffness as tendon_stiffness
from tendon_mj.theory.stiffness import transmission_stiffness as transmission_stiffness
from tendon_mj.theory.tension_memory import TensionMemory as TensionMemory
from tendon_mj.theory.transmission import first_displacement as first_displacement
from tendon_mj.theory.transmission import first_input_tension as first_input_tension
from tendon_mj.theory.transmission import first_output_tension as first_output_tension
