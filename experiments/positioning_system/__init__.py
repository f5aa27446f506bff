"""What a carriage on a ball screw lacks: friction, from three descriptions of one file."""
