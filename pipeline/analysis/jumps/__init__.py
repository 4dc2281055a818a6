"""Attractors followed along rows, upwards and downwards."""
