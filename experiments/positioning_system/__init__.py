"""A carriage on a ball screw: its missing friction, from three descriptions of one file."""
