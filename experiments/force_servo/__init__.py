"""Study of the force servo of Kaneko and others (1991), section 3."""
