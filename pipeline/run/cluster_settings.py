"""What the settings of a cluster may be, and what they say of a scheduler: its address and the keys to reach it."""

import importlib.util
import json
import re
from pathlib import Path

from pipeline.config.schema import Cluster
from pipeline.errors import ConfigurationError
from pipeline.run.libraries import load_dask
from pipeline.run.slurm_settings import JobSettings, job_settings

__all__ = ["REMOTE", "address_of", "check_cluster", "check_start", "jobs_of", "security_of", "setting_of", "unreached"]

#: Kinds whose workers are on other machines: they need not see what this process compiles.
REMOTE = ("scheduler", "slurm")

#: Transport, host (a name, an IPv4 or an IPv6 address) and port.
_ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9A-Fa-f:.%\w]+\]|[\w.-]+):(\d{1,5})")
#: Bytes of a scheduler's file at most; one says its workers too.
_MOST_BYTES = 2**24
#: Bytes that a worker must have: 270 MB hold what it loads, and dask gives it no task above four fifths of its limit.
_LEAST_MEMORY = 500_000_000


def check_cluster(config: Cluster) -> None:
    """Raise ConfigurationError unless the cluster settings make sense; nothing is started."""
    if config.kind == "local" and config.workers < 1:
        raise ConfigurationError(f"cluster.workers = {config.workers} is not allowed: it must be from 1 to 1024")
    if config.memory != "auto":
        load_dask()
        _check_memory(config)
    if config.dashboard and importlib.util.find_spec("bokeh") is None:
        raise ConfigurationError("cluster.dashboard = True is not allowed here: it needs the package bokeh")
    if config.kind == "scheduler":
        security_of(config, address_of(config))
    if config.kind == "slurm":
        jobs_of(config)


def jobs_of(config: Cluster) -> JobSettings:
    """The settings of jobs, checked."""
    return job_settings(config, _LEAST_MEMORY)


def check_start(config: Cluster) -> None:
    """Raise ConfigurationError unless workers can be started or reached here; dask is loaded, which takes a second."""
    load_dask()
    from distributed.system import MEMORY_LIMIT

    if config.kind == "local" and config.memory == "auto" and config.workers * _LEAST_MEMORY > MEMORY_LIMIT:
        raise ConfigurationError(
            f"cluster.workers = {config.workers} is not allowed here: the memory of this machine, "
            f"{MEMORY_LIMIT / 1e9:.3g} GB, is enough for {MEMORY_LIMIT // _LEAST_MEMORY}"
        )


def _check_memory(config: Cluster) -> None:
    """The size is allowed, and enough for a worker to begin."""
    from dask.utils import parse_bytes

    try:
        enough = parse_bytes(config.memory) >= _LEAST_MEMORY
    except (ValueError, OverflowError):
        enough = False
    if not enough:
        raise ConfigurationError(
            f"cluster.memory = {config.memory!r} is not allowed: it must be auto or a size such as 4GB, "
            f"{_LEAST_MEMORY / 1e6:.0f}MB at least"
        )


def setting_of(config: Cluster) -> str:
    """The setting that says where the scheduler is, with its value."""
    if config.scheduler_file:
        return f"cluster.scheduler_file = {config.scheduler_file!r}"
    return f"cluster.address = {config.address!r}"


def address_of(config: Cluster) -> str:
    """The address of the scheduler, given or read from the scheduler's file.

    Raises
    ------
    ConfigurationError
        If none is said, or both, or it is none.
    """
    if bool(config.address) == bool(config.scheduler_file):
        raise ConfigurationError(
            f"cluster.address = {config.address!r} is not allowed with "
            f"cluster.scheduler_file = {config.scheduler_file!r}: "
            "one of them must say where the scheduler is, such as tcp://host:8786"
        )
    address = _read_address(config) if config.scheduler_file else config.address
    found = _ADDRESS.fullmatch(address)
    if found is None or not 0 < int(found[3]) < 2**16:
        said = f", and it says {address[:80]!r}" if config.scheduler_file else ""
        raise ConfigurationError(
            f"{setting_of(config)} is not allowed: it must be that of a dask scheduler, "
            f"tcp://host:port or tls://host:port{said}"
        )
    return address


def _read_address(config: Cluster) -> str:
    try:
        file = Path(config.scheduler_file).expanduser()
        if not file.is_file() or file.stat().st_size > _MOST_BYTES:
            raise ValueError
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        if isinstance(address, str):
            return address
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        pass
    raise ConfigurationError(f"{setting_of(config)} is not allowed: it must be a file that dask scheduler wrote")


def security_of(config: Cluster, address: str):
    """What the client needs to speak with the scheduler at an address: a `distributed.Security`.

    What `cluster.security` leaves open is as dask's own configuration says.

    Raises
    ------
    ConfigurationError
        If files are missing, cannot be used, or are of no use.
    """
    from distributed import Security

    names = {"ca_file": "tls_ca_file", "cert": "tls_client_cert", "key": "tls_client_key"}
    given = {name: value for name in names if (value := getattr(config.security, name)) is not None}
    encrypted = address.startswith("tls://")
    for name, value in given.items():
        if not encrypted:
            raise ConfigurationError(
                f"cluster.security.{name} = {value!r} is not allowed: only an address tls://host:port needs it"
            )
        _check_file(f"cluster.security.{name}", value)
    if not encrypted:
        return Security()
    security = Security(**{names[name]: value for name, value in given.items()})
    for name in ("ca_file", "cert"):
        if getattr(security, names[name]) is None:
            raise ConfigurationError(
                f"cluster.security.{name} = None is not allowed with an address tls://host:port: "
                "it must be a file in PEM format (ca_file, cert and key are needed)"
            )
    try:
        security.get_connection_args("client")
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"cluster.security = {', '.join(f'{name}: {value}' for name, value in given.items())} is not allowed: "
            f"they must be certificates and a key that belong together ({' '.join(str(error).split())})"
        ) from None
    return security


def unreached(config: Cluster, address: str, security, error: Exception) -> ConfigurationError:
    """What is said where no scheduler answered: which file does not fit, or which transport the other one may be.

    Parameters
    ----------
    config : Cluster
    address : str
    security : distributed.Security
        With which it was tried.
    error : Exception
        What came of it.
    """
    said = " ".join(str(error).split()) or type(error).__name__
    if address.startswith("tls://"):
        if re.search(r"certificate.(does not match|verify.failed)", said, re.IGNORECASE):
            return ConfigurationError(
                f"cluster.security.ca_file = {security.tls_ca_file!r} is not allowed: it must be the authority that "
                f"signed the certificate of the scheduler at {address}"
            )
        # One that hangs up when it has shown a certificate of that authority did not like ours; it may say so or not.
        if re.search(r"alert|unknown.ca|certificate.required|<TLS .*EOF", said, re.IGNORECASE):
            return ConfigurationError(
                f"cluster.security.cert = {security.tls_client_cert!r} is not allowed: it must be signed by the "
                f"authority that the scheduler at {address} goes by, which did not accept it"
            )
    # What hangs up at the first word speaks otherwise.
    other = "tcp" if address.startswith("tls://") else "tls"
    hangs_up = re.search(r"reset|closed|not idle|wrong.version", said, re.IGNORECASE)
    advice = f"; it may be one at {other}://{address.partition('://')[2]}" if hangs_up else ""
    return ConfigurationError(
        f"{setting_of(config)} is not allowed: it must be that of a dask scheduler, and none answered there within "
        f"{config.timeout:g} s ({said}){advice}"
    )


def _check_file(name: str, value: str) -> None:
    try:
        # OpenSSL would ask at the terminal for the passphrase.
        locked = b"ENCRYPTED" in Path(value).read_bytes()
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise ConfigurationError(
            f"{name} = {value!r} is not allowed: it must be a file in PEM format ({reason})"
        ) from None
    if locked:
        raise ConfigurationError(f"{name} = {value!r} is not allowed: the key must not need a passphrase")
