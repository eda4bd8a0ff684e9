"""Observers as C99 for embedded targets."""

from observers.embedded.generating import generate
from observers.embedded.reals import DOUBLE, SINGLE, Real

__all__ = ["DOUBLE", "SINGLE", "Real", "generate"]
