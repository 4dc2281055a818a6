"""Compiled kernels: how they are compiled and kept, and the small linear algebra that they share."""
