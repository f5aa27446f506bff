"""Tendon-sheath friction for MuJoCo.

Importing this package registers the engine plugin `tendon_mj.sheath`, so that models which use it
can be loaded.
"""

from tendon_mj.engine import register as _register

_register()
