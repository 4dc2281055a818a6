"""What one motion does along a row of a plane while the swept parameter goes up and down again, and its spectra."""
