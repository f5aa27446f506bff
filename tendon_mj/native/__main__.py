"""Build the library now, so that no later import has to: ``python -m tendon_mj.native``."""

from tendon_mj.native.library import load

print(f"tendon_mj: its library is {load().path}")
