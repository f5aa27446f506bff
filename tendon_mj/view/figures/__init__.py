"""Figures from data."""
