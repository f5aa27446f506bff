"""Frames and clips of a model, the tendon coloured by its tension."""
