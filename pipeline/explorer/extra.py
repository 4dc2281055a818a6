"""What pages need and a plain installation does not have."""

import importlib.util

from pipeline.errors import ConfigurationError

__all__ = ["check_installed"]


def check_installed(stage: str, *packages: str) -> None:
    """Raise ConfigurationError, which says what to install, unless all packages that a stage needs are there."""
    missing = [name for name in packages if importlib.util.find_spec(name) is None]
    if missing:
        raise ConfigurationError(
            f"stages=[{stage}] needs {' and '.join(missing)}, not installed here: pip install 'bevelmap[explore]'"
        )
