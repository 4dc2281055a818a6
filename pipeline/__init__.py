"""From a configuration to stored planes, and from these to figures and tables."""

__all__ = ["open_plane", "scales_of", "thresholds"]


def __getattr__(name: str):
    # The solver takes seconds to load, which a refused configuration need not wait for.
    if name == "thresholds":
        from pipeline.regions import thresholds

        return thresholds
    if name == "open_plane":
        from pipeline.opened import open_plane

        return open_plane
    if name == "scales_of":
        from pipeline.physical import scales_of

        return scales_of
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
