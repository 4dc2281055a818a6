"""What `--cfg`, `--info` and `--version` print: the configuration, where it comes from, and which program this is."""

from importlib import metadata

from pipeline.config.typed import GROUPS, conf_folder
from pipeline.errors import ConfigurationError, shown

__all__ = ["configuration", "information", "version"]

_ABSENT = object()
_LIBRARIES = ("numpy", "numba", "dask", "zarr", "xarray", "hydra-core")


def version() -> str:
    """Name and version of this program."""
    try:
        return f"bevelmap {metadata.version('bevelmap')}"
    except metadata.PackageNotFoundError:
        return "bevelmap (not installed: run from its sources)"


def configuration(settings, package: str | None = None) -> str:
    """The resolved configuration, or one section of it, as YAML.

    Parameters
    ----------
    settings : pipeline.config.compose.Settings
    package : str, optional
        The section, such as "gear.variation".

    Raises
    ------
    ConfigurationError
        If there is no such section, or OmegaConf cannot read what it is called.
    """
    if package is None:
        return settings.yaml()
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    try:
        part = OmegaConf.select(OmegaConf.structured(settings.shown), package, default=_ABSENT)
    except OmegaConfBaseException as error:
        reason = str(error).partition("\n")[0]
        raise ConfigurationError(
            f"--package {shown(package)} is not allowed: it must be keys with points between them, such as "
            f"gear.variation ({shown(reason)})"
        ) from None
    if part is _ABSENT:
        raise ConfigurationError(f"--package {shown(package)} is not allowed: the configuration has no such section")
    if OmegaConf.is_config(part):
        return OmegaConf.to_yaml(part)
    return "null\n" if part is None else f"{part}\n"


def information(settings) -> str:
    """Which program this is, where configuration files are looked for, which were taken, and where results go."""
    found = {library: _version(library) for library in _LIBRARIES}
    folders = [str(conf_folder()), *([settings.config_dir] if settings.config_dir else [])]
    lines = [
        f"{version()}, with {', '.join(f'{library} {number}' for library, number in found.items())}",
        f"configuration: {', '.join(folders)}",
        f"choices: {' '.join(f'{group}={settings.choices[group]}' for group in GROUPS)}",
        f"store: {settings.store_path.resolve()}",
    ]
    return "\n".join(lines) + "\n"


def _version(library: str) -> str:
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return "missing"
