"""From overrides to a checked configuration: composition by Hydra, types by the schema, one line for every mistake."""

import dataclasses
import difflib
import itertools
import re
import typing
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from omegaconf import OmegaConf
from omegaconf.errors import ConfigAttributeError, ConfigKeyError, OmegaConfBaseException

from pipeline.config.files import check_files
from pipeline.config.folders import local_folder
from pipeline.config.schema import Configuration
from pipeline.errors import ConfigurationError

__all__ = ["Settings", "compose", "conf_folder", "expand"]

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+=-]{0,119}")


@dataclass(frozen=True)
class Settings:
    """One composed, typed and resolved configuration.

    Parameters
    ----------
    config : Configuration
    overrides : tuple of str
        As the user typed them.
    choices : dict
        Which file each group took, e.g. {"gear": "published"}.
    config_dir : str or None
        The folder of the user's own files.
    """

    config: Configuration
    overrides: tuple[str, ...]
    choices: dict[str, str]
    config_dir: str | None = None

    @property
    def store_name(self) -> str:
        """`store.name`, or the plane's name with what is not usual: see `name_of`."""
        name = self.config.store.name
        return self.name_of(self.choices["plane"]) if name is None else name

    def name_of(self, plane: str) -> str:
        """Default name of a store: -<gear> unless published, -<quality> unless paper, -order<H> and -period<nu>."""
        extras = [(self.choices["gear"], "published"), (self.choices["quality"], "paper")]
        words = [plane, *(name for name, usual in extras if name != usual)]
        if self.config.solver.balance != "describing_function":
            words.append(f"order{self.config.solver.order}")
        if self.config.solver.period != 1:
            words.append(f"period{self.config.solver.period}")
        return "-".join(words)

    @property
    def store_path(self) -> Path:
        """Where the store is."""
        return Path(self.config.store.root) / f"{self.store_name}.zarr"

    @property
    def output_root(self) -> Path:
        """Where everything that is not a store goes."""
        return Path(self.config.output.root)

    def overridden(self, key: str) -> bool:
        """Whether the user gave this key, or one above or below it, a value."""
        names = [re.split("[=@]", override.lstrip("+~"))[0] for override in self.overrides]
        return any(name == key or name.startswith(f"{key}.") for name in names)

    def yaml(self) -> str:
        """The resolved configuration."""
        return OmegaConf.to_yaml(OmegaConf.structured(self.config))


def conf_folder() -> Path:
    """The configuration folder: inside the installed package where it exists, else the repository's."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "conf", package.parent / "conf"):
        if (folder / "config.yaml").is_file():
            return folder
    raise ConfigurationError(f"no configuration found at {package / 'conf'} or {package.parent / 'conf'}")


def expand(overrides: Sequence[str]) -> list[list[str]]:
    """All combinations of comma-separated values, in the order in which Hydra's multirun takes them."""
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException

    for override in overrides:
        if not re.match(r"[+~]{0,2}[A-Za-z]", override):
            raise ConfigurationError(f"{override} is not allowed: it must be KEY=VALUE, such as gear.b=0.5")
    parser, choices = OverridesParser.create(), []
    for override in overrides:
        try:
            parsed = parser.parse_override(override)
        except HydraException as error:
            raise ConfigurationError(f"{override} cannot be read as KEY=VALUE: {_one_line(error)}") from None
        if parsed.is_sweep_override():
            key = parsed.get_key_element()
            choices.append([f"{key}={value}" for value in parsed.sweep_string_iterator()])
        else:
            choices.append([override])
    return [list(combination) for combination in itertools.product(*choices)]


def compose(overrides: Sequence[str], config_dir: str | None = None) -> Settings:
    """Compose, type and resolve one configuration.

    Parameters
    ----------
    overrides : sequence of str
        As typed, `gear.b=0.5`.
    config_dir : str, optional
        A folder with the user's own gear, plane, ... files.

    Returns
    -------
    Settings

    Raises
    ------
    ConfigurationError
        One line that names the key.
    """
    import hydra
    from hydra.errors import HydraException

    extra = []
    if config_dir is not None:
        folder = Path(config_dir)
        if not folder.is_dir():
            raise ConfigurationError(f"--config-dir = {config_dir!r} is not allowed: it must be an existing folder")
        check_files(folder)
        extra = [f"hydra.searchpath=['file://{folder.resolve()}']"]
    for override in overrides:
        if override.lstrip("+~").startswith("hydra"):
            raise ConfigurationError(f"{override}: Hydra's own settings are fixed here, so that it writes nothing")
    try:
        with hydra.initialize_config_dir(version_base="1.3", config_dir=str(conf_folder())):
            composed = hydra.compose("config", [*overrides, *extra], return_hydra_config=True)
        choices = dict(composed.hydra.runtime.choices)
        plain = OmegaConf.masked_copy(composed, [key for key in composed if key != "hydra"])
        typed = OmegaConf.merge(OmegaConf.structured(Configuration), plain)
        OmegaConf.resolve(typed)
        missing = OmegaConf.missing_keys(typed)
        if missing:
            raise ConfigurationError(f"{min(missing)} has no value")
        config = OmegaConf.to_object(typed)
        config.output.root = local_folder("output.root", config.output.root)
        config.store.root = local_folder("store.root", config.store.root)
        if config.debug.row is not None:
            # Looking at one row is then all that is done.
            config.stages = ["debug"]
    except (HydraException, OmegaConfBaseException) as error:
        raise ConfigurationError(_one_line(error)) from None
    groups = {key: str(value) for key, value in choices.items() if not key.startswith("hydra/")}
    settings = Settings(config, tuple(overrides), groups, config_dir)
    if not _NAME.fullmatch(settings.store_name):
        raise ConfigurationError(
            f"store.name = {settings.store_name!r} is not allowed: "
            "it must be a plain name of at most 120 letters, digits and _ . + = -, without a folder"
        )
    return settings


def _keys() -> list[str]:
    """All keys of the configuration, dotted."""

    def walk(schema, prefix):
        for field in dataclasses.fields(schema):
            yield f"{prefix}{field.name}"
            # A section that may be null is a union with None.
            for kind in (field.type, *typing.get_args(field.type)):
                if dataclasses.is_dataclass(kind):
                    yield from walk(kind, f"{prefix}{field.name}.")

    return list(walk(Configuration, ""))


def _one_line(error: Exception) -> str:
    """What Hydra or OmegaConf says, on one line that names the key."""
    detail = error.__cause__ if isinstance(error.__cause__, OmegaConfBaseException) else error
    if isinstance(detail, OmegaConfBaseException):
        said = str(detail.msg or detail).splitlines()[0]
        key = detail.full_key or ""
        if isinstance(detail, ConfigKeyError | ConfigAttributeError):
            key = key or str(detail.key)
            if key.startswith("gear.physical.") and key in _keys():
                return f"{key} is not allowed here: this gear is dimensionless; gear=miter is one in physical units"
            if key.startswith("plane.parameter2.") and key in _keys():
                return (
                    f"{key} is not allowed here: this plane has no third axis; plane=omega_b_fe has one, and "
                    "plane.parameter2={name:f_e,min:0,max:0.5,num:11} makes one"
                )
            close = difflib.get_close_matches(key, _keys(), n=1)
            return f"{key} is not a key of the configuration{f': did you mean {close[0]}?' if close else ''}"
        if "is not a ListConfig, list or tuple" in said:
            said = f"{key} is not allowed: it must be a list, such as [a,b]"
        return said if key in said else f"{key}: {said}"
    said = " ".join(str(error).split())
    # Where Hydra looked for a file, and where its grammar is explained, does not help here.
    return re.split(r" Config search path:| See https?://", said)[0]
