"""Checks of the configurations of sheaths and of their sensors, while MuJoCo compiles the model."""
