"""The one exception of the solver: a parameter with a value that is not allowed."""

__all__ = ["ParameterError"]


class ParameterError(ValueError):
    """A parameter has a value that is not allowed.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value
        What it was.
    allowed : str
        What it may be, as the end of the sentence "... is not allowed: it must be".
    """

    def __init__(self, name: str, value, allowed: str):
        super().__init__(f"{name} = {value!r} is not allowed: it must be {allowed}")
        self.name, self.value, self.allowed = name, value, allowed

    def __reduce__(self):
        return type(self), (self.name, self.value, self.allowed)
