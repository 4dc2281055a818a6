"""Several planes by one command: their tasks in one list on one cluster, one index, and the whole as xarray has it."""
