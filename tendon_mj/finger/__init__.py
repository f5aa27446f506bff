"""The finger in motion: trajectories, control, tracking error."""
