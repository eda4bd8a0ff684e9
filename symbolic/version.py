"""The version of brushgrip, of which all packages here are a part."""

import importlib.metadata


def version() -> str:
    """The version of brushgrip; a checkout that is not installed has none."""
    try:
        return importlib.metadata.version("brushgrip")
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"
