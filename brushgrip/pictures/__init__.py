"""The pictures of the report, drawn without pyplot and its global state."""

from brushgrip.pictures.candidates import draw_candidates
from brushgrip.pictures.decay import draw_free_decay
from brushgrip.pictures.friction import draw_friction
from brushgrip.pictures.loops import draw_loops
from brushgrip.pictures.residuals import draw_residuals
from brushgrip.pictures.style import representative

__all__ = [
    "draw_candidates",
    "draw_free_decay",
    "draw_friction",
    "draw_loops",
    "draw_residuals",
    "representative",
]
