"""The methods of [Györök 2022], kept as baselines: zone state machine, root solve per sample."""

from observers.thesis.zone_history import ZoneHistory, zone_history
from observers.thesis.zone_root_solver import CLOSE, ZoneRootSolver, ZoneRootState, nearest
from observers.thesis.zone_state_machine import TorqueCurve, ZoneState, advance_zones, branch, curve

__all__ = [
    "CLOSE",
    "TorqueCurve",
    "ZoneHistory",
    "ZoneRootSolver",
    "ZoneRootState",
    "ZoneState",
    "advance_zones",
    "branch",
    "curve",
    "nearest",
    "zone_history",
]
