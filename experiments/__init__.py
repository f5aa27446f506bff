"""Runnable experiments; they use the public API of `tendon_mj` only."""
