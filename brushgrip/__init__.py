"""The command line and the report; no physics and no estimation.

interrupts lets a process be ended at any instant; app parses the command line; commands holds a file per
command: its options, as a frozen dataclass, and what it does with them. Only a command that runs imports
numbers and pictures, so that help is quick. What commands share is in pipeline: it locates and reads
their inputs and stages their results. estimation runs observers, batch over many recordings, cluster
elsewhere. Results become text (formatting), lines on the screen (console), pictures (pictures), a page
(report) and files that are written whole or not at all (atomic).
"""

from brushgrip.door import __getattr__ as __getattr__

__all__ = ["FrictionTrack", "main", "write_report"]
__dir__ = __all__.copy
