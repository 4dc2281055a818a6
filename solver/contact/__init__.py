"""The contact force with backlash: dead zone, exact Fourier coefficients, impact states."""
