"""The package stays out of what every user of the solver imports."""

import subprocess
import sys


def test_solver_does_not_import_the_time_domain():
    code = "import sys, solver; sys.exit(any(name.startswith('solver.timedomain') for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
