"""Figures drawn from a stored plane."""
