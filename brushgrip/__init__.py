"""The command line and the report; no physics and no estimation."""

from brushgrip.app import main
from brushgrip.friction import FrictionTrack
from brushgrip.report import write_report

__all__ = ["FrictionTrack", "main", "write_report"]
