"""Every motion at one point of a plane: those of the map in time, and the attractors that integration finds."""
