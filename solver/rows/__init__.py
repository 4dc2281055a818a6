"""One row of a plane: seeds, branches and the solutions at its grid values."""
