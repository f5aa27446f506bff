"""What sheaths cost a step and a simulation, and what the alternatives cost."""
