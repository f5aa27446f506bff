"""Hidden fleets: rigs of one kind recorded over days, some of which change in something."""
