"""Measured antagonistic joint behind a bent sheath: what its frictionless model lacks."""
