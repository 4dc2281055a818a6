"""Curves of solutions of any E(u, p) = 0: correctors, arc-length continuation, points on a curve."""
