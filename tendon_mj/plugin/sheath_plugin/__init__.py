"""The plugin `tendon_mj.sheath`."""
