"""The command line and the report; no physics and no estimation.

cli parses the command line; commands holds a file per command: its options, as a frozen dataclass, and
what it does with them. Only a command that runs imports numbers and pictures, so that help is quick.
inputs locates and reads what a command is given, outputs stages what it writes and prints; running takes
long work to processes. estimation runs observers and models over recordings. Results become text
(wording), pictures (pictures) and a page (report); comparison holds the methods of `compare`, published
the recordings that can be downloaded.
"""

from brushgrip.cli.lazy_exports import __getattr__ as __getattr__

__all__ = ["FrictionTrack", "main", "write_report"]
__dir__ = __all__.copy
