"""The path of a tendon: over sites, around geoms, in branches."""
