"""A stored plane, opened for questions: segments of branches, labels, resonances, peaks, regions."""
