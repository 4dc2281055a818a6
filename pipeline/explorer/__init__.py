"""A stored plane in a browser: asked by clicking, answered by computing."""
