"""A car that is steered at standstill: what it is made of."""

from dataclasses import dataclass, field

from reference_rig.car_gear import Assistance, GearFriction, Joint
from reference_rig.car_geometry import Kingpin, Linkage
from reference_rig.car_patch import CarTyre


@dataclass(frozen=True, kw_only=True)
class Car:
    """The true car."""

    linkage: Linkage = field(default_factory=Linkage)
    kingpin: Kingpin = field(default_factory=Kingpin)
    tyre: CarTyre = field(default_factory=CarTyre)
    friction: GearFriction = field(default_factory=GearFriction)
    rod: Joint = field(default_factory=Joint)
    assistance: Assistance | None = field(default_factory=Assistance)
    axle_load: float = 7500.0  # Front axle [N].
    left_share: float = 0.5  # Of the axle load on the left wheel at rest [1].
    mu: tuple[float, float] = (0.9, 0.9)  # Friction under the left and the right wheel [1].
    wheelbase: float = 2.6  # [m]
    pinion_radius: float = 0.0075  # Way of the rack for one radian of the pinion [m].
    torsion_bar: float = 115.0  # [N m/rad]
    column: float = 1500.0  # Stiffness of shafts and joints between handwheel and torsion bar [N m/rad].
    rack_mass: float = 12.0  # Rack, pinion and their shafts, at the rack [kg].
    wheel_inertia: float = 1.1  # About the kingpin [kg m²].
    wheel_damping: float = 15.0  # Of ball joints and bushes about the kingpin [N m s].
    handwheel_inertia: float = 0.035  # [kg m²]
    # Load that crosses from wheel to wheel for the difference of the wheels' lifts [N/m].
    warp_stiffness: float = 2.5e4
    # Of the body on braked rear tyres about the middle of the rear axle [N m/rad].
    yaw_stiffness: float = 2.5e5
    free_yaw_stiffness: float = 8e3  # The same while the rear wheels roll [N m/rad].
    yaw_inertia: float = 4500.0  # Of the body about the middle of the rear axle [kg m²].
    rolling_mass: float = 12.0  # Of a wheel that rolls, at the tread [kg].

    @property
    def moved_mass(self) -> float:
        """Rack with what turns with it, the rotor as well [kg]."""
        motor = self.assistance
        rotor = motor.inertia * (motor.ratio / self.pinion_radius) ** 2 if motor else 0.0
        return self.rack_mass + rotor

    @property
    def lock(self) -> float:
        """Rack displacement at which the inner wheel has turned by 0.65 rad [m]."""
        return self.linkage.rack_at(1.0, 0.65)
