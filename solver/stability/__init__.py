"""Dynamic stability of steady motions, and where it changes."""
