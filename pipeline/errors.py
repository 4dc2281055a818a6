"""What a user can get wrong, as exceptions with a one-line message."""

__all__ = ["ConfigurationError", "StoreError"]


class ConfigurationError(Exception):
    """The configuration is not allowed; the message names the key, its value and what is allowed. Exit status 2."""


class StoreError(ConfigurationError):
    """A store cannot be used as asked; the message names it and the way on. Exit status 2."""
