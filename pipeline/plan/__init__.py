"""What a run computes: axes, gears, blocks of rows; from a configuration to a plan."""
