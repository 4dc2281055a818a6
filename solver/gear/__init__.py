"""From a drawing to dimensionless numbers: blanks, gear pairs, scales, mesh cycles, temperature."""
