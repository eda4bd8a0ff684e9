"""The methods of [Györök 2022], kept as baselines: zone state machine, root solve per sample."""

from observers.thesis.zone_state_machine import Fragmentation, turned

__all__ = ["Fragmentation", "turned"]
