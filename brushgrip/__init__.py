"""The command line and the report; no physics and no estimation.

interrupts lets a process be ended at any instant; app parses the command line; commands holds what a
user types, a file per command, tasks what it does and comparison the methods of `compare`. Only a task
imports numbers and pictures, so that help is quick. recordings finds and reads files, user_effects
imports a user's effects, estimation runs observers, fleet over many recordings, cluster elsewhere.
Results become text (formatting), lines on the screen (console), pictures (pictures), a page (report) and
files that are written whole or not at all (atomic); unfinished keeps an interrupted search, fetch
downloads the published measurements.
"""

from brushgrip.door import __getattr__ as __getattr__

__all__ = ["FrictionTrack", "main", "write_report"]
__dir__ = __all__.copy
