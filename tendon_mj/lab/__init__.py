"""Laboratory: recordings, replay, diagnosis, experiment design, sweeps, fleets (extra `lab`)."""
