"""The one tree of errors."""


class BrushgripError(Exception):
    """Root of every error that this project raises on purpose."""


class InvalidInputError(BrushgripError, ValueError):
    """Bad input from the user: one line that names file, row, the fault and what is allowed."""
