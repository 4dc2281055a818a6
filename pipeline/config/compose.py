"""From overrides to a checked configuration: composition by Hydra, types by the schema, one line for every mistake."""

import contextlib
import dataclasses
import difflib
import functools
import pickle
import re
import typing
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import ConfigAttributeError, ConfigKeyError, MissingMandatoryValue, OmegaConfBaseException

from pipeline.config.allowed import check_all
from pipeline.config.default_name import default_name, is_name
from pipeline.config.files import check_files
from pipeline.config.folders import local_folder
from pipeline.config.places import Place, place_of
from pipeline.config.schema import Configuration
from pipeline.config.secrets import hidden, hidden_values
from pipeline.config.typed import GROUPS, SYSTEMS, conf_folder, expand, key_of, loader, parsed
from pipeline.errors import ConfigurationError, shown

__all__ = ["Settings", "compose", "conf_folder", "expand"]

#: An override that gives a key its value; of other keys without a dot any may choose a file.
_VALUE = re.compile(r"stages=.*|[+~]{0,2}\w+(?:\.\w+)+(?:=.*)?", re.DOTALL)


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
    default_name : str
        Of the store, where `store.name` is null; see `pipeline.config.default_name`.
    config_dir : str or None
        The folder of the user's own files.
    """

    config: Configuration
    overrides: tuple[str, ...] = dataclasses.field(repr=False)
    choices: dict[str, str]
    default_name: str
    config_dir: str | None = None

    @property
    def store_name(self) -> str:
        """`store.name`, or the default name."""
        name = self.config.store.name
        return self.default_name if name is None else name

    @property
    def store_root(self) -> Place:
        """Where stores are."""
        return place_of("store.root", self.config.store.root, self.config.store.storage_options)

    @property
    def store_path(self) -> Place:
        """Where the store is."""
        return self.store_root / f"{self.store_name}.zarr"

    @property
    def output_root(self) -> Path:
        """Where everything that is not a store goes."""
        return Path(self.config.output.root)

    def overridden(self, key: str) -> bool:
        """Whether the user gave this key, or one below it, a value."""
        return any(name == key or name.startswith(f"{key}.") for name in map(key_of, self.overrides))

    def typed(self, key: str) -> bool:
        """Whether the user gave this key a value of its own, or one of the sections that it is in; a choice of a
        group's file does neither."""
        names = {key_of(override) for override in self.overrides} - set(GROUPS)
        return any(key == name or key.startswith(f"{name}.") for name in names)

    def chosen(self, group: str) -> bool:
        """Whether the user chose the file of a group."""
        return group in map(key_of, self.overrides)

    def of_plane(self, plane: str) -> "Settings":
        """The same settings for another plane, under its default name; without what its axes replace."""
        kept = [override for override in self.overrides if key_of(override) not in ("plane", "store.name")]
        found = compose([f"plane={plane}", *kept], self.config_dir)
        axes = (found.config.plane.sweep, found.config.plane.parameter, found.config.plane.parameter2)
        names = {axis.name for axis in axes if axis is not None}
        replaced = {key for key in map(key_of, kept) if key.startswith("gear.") and key.rpartition(".")[2] in names}
        if not replaced:
            return found
        return compose(
            [f"plane={plane}", *(override for override in kept if key_of(override) not in replaced)], self.config_dir
        )

    @property
    def shown(self) -> Configuration:
        """The configuration as it may be shown and stored: without the values of storage options."""
        store = self.config.store
        return replace(self.config, store=replace(store, storage_options=hidden_values(store.storage_options)))

    def yaml(self) -> str:
        """The resolved configuration."""
        # Values are typed already: as plain data they are written without being checked once more.
        return OmegaConf.to_yaml(OmegaConf.create(dataclasses.asdict(self.shown)))


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
    try:
        return _composed_settings(overrides, config_dir)
    except ConfigurationError as error:
        raise ConfigurationError(hidden(str(error), overrides)) from None


def _composed_settings(overrides: Sequence[str], config_dir: str | None) -> Settings:
    try:
        Path.cwd()
    except OSError as error:
        raise ConfigurationError(f"the current folder cannot be used, change into another one: {error}") from None
    if config_dir is not None:
        folder = Path(config_dir)
        if not folder.is_dir():
            raise ConfigurationError(f"--config-dir = {config_dir!r} is not allowed: it must be an existing folder")
        check_files(folder)
    runs = expand(overrides, config_dir)
    if len(runs) > 1:
        raise ConfigurationError(f"{shown(' '.join(overrides))}: several values need -m")
    (overrides,) = runs
    config, choices = _composed(tuple(overrides), config_dir)
    for name in ("gear", "plane", "solver", "cluster", "quality", "output", "store"):
        if getattr(config, name) is None:
            raise ConfigurationError(f"{name} has no value")
    config.output.root = local_folder("output.root", config.output.root)
    config.store.root = str(place_of("store.root", config.store.root, config.store.storage_options))
    check_all(config)
    if config.debug.row is not None:
        # Looking at one row is then all that is done.
        config.stages = ["debug"]
    settings = Settings(config, tuple(overrides), choices, _name(config, choices, overrides, config_dir), config_dir)
    if not is_name(settings.store_name):
        raise ConfigurationError(
            f"store.name = {shown(settings.store_name)!r} is not allowed: it must be a plain name of at most 120 "
            "letters, digits and _ . + = -, without a folder, that every system takes"
        )
    _check_links({"store.root": settings.store_path, "output.root": settings.output_root})
    return settings


def _check_links(places: dict[str, Place]) -> None:
    """Raise if a path, the value of its key or in it, is a link that leads to itself."""
    for key, place in places.items():
        try:
            place.resolve()
        except (RuntimeError, OSError) as error:
            # Python 3.13 leaves it to whoever opens the file.
            raise ConfigurationError(f"{key} is not allowed: {place} cannot be followed ({error})") from None


def _composed(overrides: tuple[str, ...], config_dir: str | None) -> tuple[Configuration, dict[str, str]]:
    """What Hydra makes of overrides, typed and resolved: the configuration, and which file each group took."""
    from hydra._internal.config_loader_impl import ConfigLoaderImpl
    from hydra.errors import HydraException

    values = [override for override in overrides if _VALUE.fullmatch(override)]
    choosing = tuple(override for override in overrides if not _VALUE.fullmatch(override))
    try:
        chosen, typed, choices = _files_chosen(choosing, config_dir, _state(config_dir))
        plain = pickle.loads(chosen)
        ConfigLoaderImpl._apply_overrides_to_config(list(map(parsed, values)), plain)
        # Where types are merged, a value that is left open would count as not given.
        left_open = OmegaConf.missing_keys(plain) if any("???" in override for override in values) else set()
        if left_open:
            raise _without_value(left_open)
        typed = _typed(plain, typed, values)
        OmegaConf.resolve(typed)
        try:
            return OmegaConf.to_object(typed), dict(choices)
        except MissingMandatoryValue:
            raise _without_value(OmegaConf.missing_keys(typed)) from None
    except (HydraException, OmegaConfBaseException) as error:
        said = _one_line(error)
        if not any(key_of(override) in said for override in overrides):
            said = f"{shown(' '.join(overrides))} is not allowed: {said}"
        raise ConfigurationError(said) from None
    except (ValueError, TypeError, ArithmeticError, AttributeError, LookupError, RecursionError, OSError) as error:
        # What Hydra and OmegaConf did not expect of an override either.
        reason = shown(" ".join(str(error).split()), 300)
        raise ConfigurationError(
            f"{shown(' '.join(overrides))} is not allowed: no configuration comes of it "
            f"({type(error).__name__}: {reason})"
        ) from None


def _without_value(keys: set[str]) -> ConfigurationError:
    return ConfigurationError(f"{min(keys)} has no value")


def _typed(plain: DictConfig, of_files: bytes | None, values: Sequence[str]) -> DictConfig:
    """A configuration with types, from what its files have and the sections that these overrides change."""
    if of_files is not None and not any(override.startswith("~") for override in values):
        changed = {key_of(override).split(".")[0] for override in values}
        # What cannot be is said of the whole.
        with contextlib.suppress(OmegaConfBaseException, ValueError, TypeError):
            return OmegaConf.unsafe_merge(pickle.loads(of_files), OmegaConf.masked_copy(plain, changed))
    return OmegaConf.unsafe_merge(OmegaConf.structured(Configuration), plain)


@functools.lru_cache(maxsize=64)
def _files_chosen(
    overrides: tuple[str, ...], config_dir: str | None, state: tuple
) -> tuple[bytes, bytes | None, tuple[tuple[str, str], ...]]:
    """What Hydra makes of the overrides that choose files, pickled; the same with types, None where a file has a value
    that has to be overridden; and which file each group took.

    It takes a twentieth of a second, and what gives keys their values is the quick part. Hydra's public way would take
    as long again for settings of its own, which nobody reads here.
    """
    from hydra._internal.config_repository import CachingConfigRepository
    from hydra._internal.defaults_list import create_defaults_list
    from hydra.version import setbase

    setbase("1.3")
    files = loader(config_dir)
    # Files are read once, both for what they choose and for what they hold.
    repository = CachingConfigRepository(files.repository)
    chosen = create_defaults_list(
        repository, "config", list(map(parsed, overrides)), prepend_hydra=False, skip_missing=False
    )
    plain = files._compose_config_from_defaults_list(chosen.defaults, repository)
    # No value may be given to a key that is not there, unless + says so.
    OmegaConf.set_struct(plain, True)
    files._apply_overrides_to_config(chosen.config_overrides, plain)
    # But the options of an object store, whose names are not known here.
    OmegaConf.set_struct(plain.store.storage_options, False)
    untyped, typed = pickle.dumps(plain), None
    with contextlib.suppress(OmegaConfBaseException, ValueError, TypeError):
        typed = pickle.dumps(OmegaConf.unsafe_merge(OmegaConf.structured(Configuration), plain))
    choices = tuple((key, str(value)) for key, value in chosen.overrides.known_choices.items())
    return untyped, typed, choices


def _state(config_dir: str | None) -> tuple:
    """Changes when a file of the configuration, or one of the user's own, does."""
    folders = [conf_folder(), *([Path(config_dir).resolve()] if config_dir is not None else [])]
    files = ((file, file.stat()) for folder in folders for file in sorted(folder.rglob("*.yaml")))
    return tuple((str(file), found.st_mtime_ns, found.st_size) for file, found in files)


def _name(config: Configuration, choices: dict, overrides: Sequence[str], config_dir: str | None) -> str:
    """Default name of the store."""
    here, keys = dataclasses.asdict(config), map(key_of, overrides)
    if all(key in GROUPS or re.split("[./]", key)[0] not in GROUPS for key in keys):
        # Files were chosen, and no value in them was typed.
        return default_name(choices, here, here)
    chosen = tuple(override for override in overrides if key_of(override) in GROUPS)
    return default_name(choices, here, _usual(chosen, config_dir, _state(config_dir)))


@functools.lru_cache(maxsize=64)
def _usual(chosen: tuple[str, ...], config_dir: str | None, state: tuple) -> dict:
    """The configuration where nothing but files of groups was chosen, as plain data."""
    return dataclasses.asdict(_composed(chosen, config_dir)[0])


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
            if key.startswith("gear.") and key in _keys():
                of = key.split(".")[1]
                example = of if of in SYSTEMS else "miter" if of in ("physical", "thermal") else "published"
                return f"{key} is not allowed here: this gear has no such key; gear={example} has it"
            if key.startswith("cluster.") and key in _keys():
                return f"{key} is not allowed here: it is a setting of jobs; cluster=slurm has it"
            close = difflib.get_close_matches(key, _keys(), n=1)
            return f"{key} is not a key of the configuration{f': did you mean {close[0]}?' if close else ''}"
        if " is not Optional" in said:
            said = re.sub(r".*'(.+)'.*", r"\1 = null is not allowed: it must have a value", said)
        if "is not a ListConfig, list or tuple" in said:
            said = f"{key} is not allowed: it must be a list, such as [a,b]"
        return shown(said if key in said else f"{key}: {said}", 500)
    said = " ".join(str(error).split())
    # Where Hydra looked for a file, and where its grammar is explained, does not help here.
    return shown(re.split(r" Config search path:| See https?://", said)[0], 500)
