"""The very first run: half of the kernels are compiled by a second process while this one compiles the other half.

Numba compiles one function after the other, and a run has two cores. What the helper compiles goes into the cache on disk,
where this process finds it when its own imports get there. Nothing depends on the helper: what it has not done is done here.
"""

import importlib.util
import subprocess
import sys
from pathlib import Path

__all__ = ["compile_beside"]

# The packages' own imports would compile everything in the same order; as bare folders they let one module be chosen.
_HELPER = """
import sys, types
for name in ("", ".boundaries", ".stability", ".harmonic"):
    package = sys.modules["solver" + name] = types.ModuleType("solver" + name)
    package.__path__ = [sys.argv[1] + name.replace(".", "/")]
import solver.stability.scan, solver.boundaries.bifurcation_curves, solver.boundaries.contact_angles
"""


def compile_beside() -> subprocess.Popen | None:
    """Start the helper if no kernel has been compiled yet; call before anything imports the solver.

    Returns
    -------
    subprocess.Popen or None
        The helper, None where the cache is warm or the solver imported already.
    """
    spec = importlib.util.find_spec("solver")
    if "solver" in sys.modules or spec is None:
        return None
    folder = Path(spec.origin).parent
    module = importlib.util.spec_from_file_location("_kernel_cache", folder / "compiled.py")
    compiled = importlib.util.module_from_spec(module)
    module.loader.exec_module(compiled)
    cache = compiled.cache_folder(folder / "arclength.py")
    if cache is None or any(Path(cache).rglob("*.nbi")):
        return None
    return subprocess.Popen([sys.executable, "-c", _HELPER, str(folder)], stdout=subprocess.DEVNULL)
