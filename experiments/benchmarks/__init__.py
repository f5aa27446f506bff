"""Cost of sheaths in a step and in a simulation, and of the alternatives."""
