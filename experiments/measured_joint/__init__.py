"""Measured antagonistic joint behind a bent sheath: effects that its frictionless model lacks."""
