"""From a configuration to stored planes, and from these to figures and tables."""

__all__ = ["compute", "open_plane", "open_study", "scales_of", "thresholds"]


def __getattr__(name: str):
    # The solver takes seconds to load, which a refused configuration need not wait for.
    if name == "thresholds":
        from pipeline.plane.regions import thresholds

        return thresholds
    if name in ("compute", "open_plane", "open_study"):
        from pipeline import api

        return getattr(api, name)
    if name == "scales_of":
        from pipeline.plan.scales import scales_of

        return scales_of
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
