"""The pictures of the report, drawn without pyplot and its global state."""

from brushgrip.pictures.boxes import draw_boxes
from brushgrip.pictures.candidates import draw_candidates
from brushgrip.pictures.decay import draw_free_decay
from brushgrip.pictures.experiment import draw_experiment
from brushgrip.pictures.friction import draw_friction
from brushgrip.pictures.loops import draw_loops
from brushgrip.pictures.profile import draw_profile
from brushgrip.pictures.residuals import draw_residuals
from brushgrip.pictures.signatures import draw_signatures
from brushgrip.pictures.style import representative
from brushgrip.pictures.zones import draw_zones

__all__ = [
    "draw_boxes",
    "draw_candidates",
    "draw_experiment",
    "draw_free_decay",
    "draw_friction",
    "draw_loops",
    "draw_profile",
    "draw_residuals",
    "draw_signatures",
    "draw_zones",
    "representative",
]
