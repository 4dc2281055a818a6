"""What takes long to import stays out of what every user of the solver, and every worker, imports."""

import subprocess
import sys


def test_solver_imports_neither_the_time_domain_nor_optimizers():
    slow = ("solver.timedomain", "solver.harmonic.galerkin", "scipy.optimize", "scipy.interpolate")
    code = f"import sys, solver, pipeline.run.rows; print([name for name in sys.modules if name.startswith({slow})])"
    result = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert result.stdout == "[]\n"
