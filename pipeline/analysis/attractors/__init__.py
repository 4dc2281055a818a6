"""What motions end on in every cell of a plane, and how far the labels of its map can be trusted."""
