"""Direct integration, periodic orbits and attractors of any system with one contact: pure numerics.

Not imported by `import solver`: the kernels are many.
"""
