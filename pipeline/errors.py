"""What a user can get wrong and what can be wrong with a store, as exceptions with a one-line message."""

__all__ = ["ComputationError", "ConfigurationError", "DamagedError", "StoreError", "WorkerLost"]


class ConfigurationError(Exception):
    """The configuration is not allowed; the message names the key, its value and what is allowed."""

    #: Exit status of a run that ends with it.
    status = 2


class StoreError(ConfigurationError):
    """A store cannot be used as asked; the message names it and the way on."""


class DamagedError(StoreError):
    """Files of a store are damaged; the message names the first one and the way on, `what` is the fault alone."""

    status = 1
    what = ""


class ComputationError(RuntimeError):
    """Something could not be computed; what could is stored."""


class WorkerLost(RuntimeError):
    """The process that ran a task ended before the task did."""
