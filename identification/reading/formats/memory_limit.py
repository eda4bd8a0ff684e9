"""A bound on the memory that libraries may take for what a file only declares."""

from symbolic.compilation.operating_system import MemoryLimit

MOST_MEMORY = 4_000_000_000
"""Beyond what the process has when it opens a file [bytes]."""
LIMIT = MemoryLimit(MOST_MEMORY)
bounded_memory = LIMIT.lowered
"""Lets what is inside take so much and no more, MemoryError otherwise; on Linux alone."""
