"""Harmonic-balance problems: what continuation solves."""
