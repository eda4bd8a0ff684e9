"""Observers as C99 for embedded targets, as FMUs and as packages of ROS 2 around the same C."""

from observers.embedded.codegen import generate, generate_ros2
from observers.embedded.fmu import generate_fmu
from observers.embedded.generated_file_overwriting import require_replaceable
from observers.embedded.native import NativeObserver, compile_native
from observers.embedded.scalar_expansion import Tunable
from observers.embedded.scalar_type import DOUBLE, SINGLE, Real
from observers.embedded.vehicle_sensor_code import generate_vehicle

__all__ = [
    "DOUBLE",
    "SINGLE",
    "NativeObserver",
    "Real",
    "Tunable",
    "compile_native",
    "generate",
    "generate_fmu",
    "generate_ros2",
    "generate_vehicle",
    "require_replaceable",
]
