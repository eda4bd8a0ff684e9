"""Pictures, drawn without pyplot and its global state.

Of a diagnosis (diagnosis), of mechanisms (mechanism_curves), of friction (friction), of identified
parameters (free_decay_parameters), and after the figures of [Györök 2022] (box_plots); style holds what
they share.
"""

from brushgrip.pictures.box_plots import draw_boxes
from brushgrip.pictures.diagnosis import (
    draw_candidates,
    draw_experiment,
    draw_loops,
    draw_residuals,
    draw_signatures,
)
from brushgrip.pictures.free_decay_parameters import draw_free_decay
from brushgrip.pictures.friction import draw_friction, draw_overview
from brushgrip.pictures.mechanism_curves import draw_mechanisms, has_curves

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
