"""The command line: what is typed, help, completion, warming kernels."""
