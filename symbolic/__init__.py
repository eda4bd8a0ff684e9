"""Ground floor: the physics of the contact patch as casadi expressions."""

from symbolic.bristles import BristlePatch, BristleTraits, Relaxation
from symbolic.compiled import compiled, compiler
from symbolic.deformation import (
    edge_distance,
    full_slide_level,
    full_slide_torque,
    position,
    unit_moment,
)
from symbolic.effects.base import Effect, Parameter, Signals, with_limit, with_shape
from symbolic.effects.learned import LearnedTorque
from symbolic.effects.library import EFFECTS, effects_named
from symbolic.effects.patch_output import PatchOutput
from symbolic.errors import BrushgripError, InvalidInputError
from symbolic.masing import (
    TurningPoints,
    branch_torque,
    deformation_limit,
    lateral_deformation,
    virgin_torque,
    zone_boundaries,
)
from symbolic.model import DECLARED, GEOMETRY, SIGNALS, Model
from symbolic.motion import Motion, TorqueProfile, simulate_motion
from symbolic.parameters import Rig, Tyre
from symbolic.patch import Patch, PatchInputs
from symbolic.trajectory import Torque, simulate, step_along
from symbolic.zones import ZonePatch

__all__ = [
    "DECLARED",
    "EFFECTS",
    "GEOMETRY",
    "SIGNALS",
    "BristlePatch",
    "BristleTraits",
    "BrushgripError",
    "Effect",
    "InvalidInputError",
    "LearnedTorque",
    "Model",
    "Motion",
    "Parameter",
    "Patch",
    "PatchInputs",
    "PatchOutput",
    "Relaxation",
    "Rig",
    "Signals",
    "Torque",
    "TorqueProfile",
    "TurningPoints",
    "Tyre",
    "ZonePatch",
    "branch_torque",
    "compiled",
    "compiler",
    "deformation_limit",
    "edge_distance",
    "effects_named",
    "full_slide_level",
    "full_slide_torque",
    "lateral_deformation",
    "position",
    "simulate",
    "simulate_motion",
    "step_along",
    "unit_moment",
    "virgin_torque",
    "with_limit",
    "with_shape",
    "zone_boundaries",
]
