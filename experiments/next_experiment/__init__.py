"""Ties of hidden effects, settled by a suggested experiment and by random ones."""
