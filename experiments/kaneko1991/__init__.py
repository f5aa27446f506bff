"""Reproduction of Figs. 4 and 5 of Kaneko and others (1991) by six routes."""
