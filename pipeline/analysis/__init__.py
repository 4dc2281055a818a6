"""What is computed from a stored plane and added to it: boundaries, attractors, margins."""
