"""Figures with Matplotlib: bars, the bench, simulations against recordings, and the style."""
