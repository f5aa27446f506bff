"""Simulation of a recording: schedule of controls, parameters, sensor readings, rollouts."""
