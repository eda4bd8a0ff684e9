"""Pictures, drawn without pyplot and its global state.

Of a diagnosis (diagnosis), of mechanisms (mechanisms), of friction (friction), of identified
parameters (parameters), and after the figures of [Györök 2022] (thesis_figures); style holds what they
share.
"""

from brushgrip.pictures.diagnosis import (
    draw_candidates,
    draw_experiment,
    draw_loops,
    draw_residuals,
    draw_signatures,
)
from brushgrip.pictures.free_decay_parameters import draw_free_decay
from brushgrip.pictures.friction import draw_friction, draw_overview
from brushgrip.pictures.mechanisms import draw_mechanisms, has_curves
from brushgrip.pictures.thesis_figures import draw_boxes

__all__ = [
    "draw_boxes",
    "draw_candidates",
    "draw_experiment",
    "draw_free_decay",
    "draw_friction",
    "draw_loops",
    "draw_mechanisms",
    "draw_overview",
    "draw_residuals",
    "draw_signatures",
    "has_curves",
]
