"""The closed form of Kaneko and others (1991) against MuJoCo, and what a step costs."""
