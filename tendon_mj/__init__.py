"""Tendon-sheath friction for MuJoCo."""
