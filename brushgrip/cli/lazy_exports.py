"""What `import brushgrip` offers, imported when it is first used: help needs none of it."""

from importlib import import_module

_HOMES = {
    "FrictionTrack": "brushgrip.estimation.observe_recording",
    "main": "brushgrip.cli.app",
    "write_report": "brushgrip.report.page",
}


def __getattr__(name: str) -> object:
    """The public name of the package, from the module that defines it."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'brushgrip' has no attribute {name!r}")
