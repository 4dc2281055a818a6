"""The equations of motion: the dimensionless pair, any system with one contact, parameters, exact condensation."""
