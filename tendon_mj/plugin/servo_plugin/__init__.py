"""The plugin `tendon_mj.servo`."""
