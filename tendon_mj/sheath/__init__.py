"""The friction model alone: its law, the flow solver, a bench without MuJoCo."""

from tendon_mj.sheath.law import Law as Law
