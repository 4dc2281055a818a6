"""Basin shares at chosen places."""
