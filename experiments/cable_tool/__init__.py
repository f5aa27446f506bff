"""Driven surgical grasper, torque and angle at both ends: which friction grows with the load."""
