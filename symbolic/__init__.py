"""Ground floor: the physics of the contact patch as CasADi expressions.

- `Model` composes a patch and any number of `EFFECTS` into CasADi Functions; `simulate` runs a recording
  through it, and `simulate_motion` a wheel with inertia.
- A subclass of `Effect` with its `Parameter`s is an effect of one's own; its hooks take `Signals`,
  `Values` and `BristleTraits`.
- `Rig` and `Tyre` hold what is known; `rig_from_tables` and `model_from_tables` read them from tables.
"""

from symbolic.bristle_patch import BristleTraits, Relaxation
from symbolic.compilation.compiled_function_cache import compiled, compiler
from symbolic.effects.base import (
    Effect,
    Parameter,
    ResidualSignature,
    Scope,
    Signals,
    Values,
    parameter_name,
    with_limit,
    with_shape,
)
from symbolic.effects.by_ground import GROUND_SCOPES
from symbolic.effects.library import CANDIDATES, EFFECTS, effects_in, effects_named
from symbolic.elements_in_series import SEARCH_STEPS
from symbolic.errors import BrushgripError, InvalidInputError
from symbolic.masing import (
    TurningPoints,
    deformation_limit,
    lateral_deformation,
    virgin_torque,
    zone_boundaries,
)
from symbolic.model import DECLARED, GEOMETRY, SIGNALS, Model
from symbolic.patch_interface import Expression
from symbolic.patch_moment_by_zones import full_slide_arm, full_slide_level, full_slide_torque
from symbolic.rig_and_tyre import (
    RIG_RANGES,
    TOLERATED,
    USUAL,
    Rig,
    Tolerances,
    Tyre,
    with_usual_tolerances,
)
from symbolic.tables.found_model import FoundModel, ModelBasis, ModelError, units_of
from symbolic.tables.found_model_from_tables import model_from_tables
from symbolic.tables.rig_from_tables import rig_from_tables
from symbolic.tables.vehicle_from_tables import vehicle_from_tables
from symbolic.trajectory_sensitivity import (
    RIG_DIRECTIONS,
    TorqueAndSensitivities,
    sensitivity_step,
    simulate,
)
from symbolic.vehicle.mean_wheel import rig_of
from symbolic.vehicle.vehicle import Vehicle, VehicleTolerances
from symbolic.wheel_motion_under_torque import TorqueProfile, WheelMotion, simulate_motion

__all__ = [
    "CANDIDATES",
    "DECLARED",
    "EFFECTS",
    "GEOMETRY",
    "GROUND_SCOPES",
    "RIG_DIRECTIONS",
    "RIG_RANGES",
    "SEARCH_STEPS",
    "SIGNALS",
    "TOLERATED",
    "USUAL",
    "BristleTraits",
    "BrushgripError",
    "Effect",
    "Expression",
    "FoundModel",
    "InvalidInputError",
    "Model",
    "ModelBasis",
    "ModelError",
    "Parameter",
    "Relaxation",
    "ResidualSignature",
    "Rig",
    "Scope",
    "Signals",
    "Tolerances",
    "TorqueAndSensitivities",
    "TorqueProfile",
    "TurningPoints",
    "Tyre",
    "Values",
    "Vehicle",
    "VehicleTolerances",
    "WheelMotion",
    "compiled",
    "compiler",
    "deformation_limit",
    "effects_in",
    "effects_named",
    "full_slide_arm",
    "full_slide_level",
    "full_slide_torque",
    "lateral_deformation",
    "model_from_tables",
    "parameter_name",
    "rig_from_tables",
    "rig_of",
    "sensitivity_step",
    "simulate",
    "simulate_motion",
    "units_of",
    "vehicle_from_tables",
    "virgin_torque",
    "with_limit",
    "with_shape",
    "with_usual_tolerances",
    "zone_boundaries",
]
__dir__ = __all__.copy
