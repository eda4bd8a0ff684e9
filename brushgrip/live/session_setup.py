"""A session as the command line describes it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from brushgrip.estimation.observe_recording import ObserverFactory
from brushgrip.estimation.recording_warnings import direction_deficit_and_note
from brushgrip.inputs.command_inputs import Inputs
from brushgrip.inputs.recording_files import locate_recording
from brushgrip.live.can_source import CanSource
from brushgrip.live.mapped_columns import MappedColumns
from brushgrip.live.row_estimation import CarStandstillEstimator, RowEstimator, WheelRowEstimator
from brushgrip.live.session_state_in_words import host_and_port
from brushgrip.live.sources import LineSource, ReplaySource, Source, UdpSource
from brushgrip.live.steering_adviser import SteeringAdviser
from brushgrip.outputs.console import print_line
from identification import READERS, Recording, Standstills, read_rig, read_vehicle
from identification.reading.checked_sample_table import Table, required_columns
from identification.reading.readers import read_table
from identification.reading.rigfile import rig_overridden_by_table
from symbolic import InvalidInputError, Rig, Tyre, rig_of


def source_and_estimator(
    spec: str,
    inputs: Inputs,
    factory: ObserverFactory,
    *,
    speed: float = 1.0,
    ground: str | None = None,
    adviser: SteeringAdviser | None = None,
) -> tuple[Callable[[], Source], RowEstimator]:
    """What opens a source, and what makes the estimates of its samples that `estimate` would make."""
    if not 0 < speed < np.inf:
        raise InvalidInputError(f"--speed must be finite and greater than 0, got {speed:g}")
    where, table = spec.removeprefix("replay:"), None
    columns = MappedColumns(where, inputs.signals, car=inputs.vehicle is not None)
    if spec != "-" and not spec.startswith(("udp:", "can:")):
        needed = ("t",) if inputs.vehicle else required_columns(torque_required=False)
        located = locate_recording(where, of_car=inputs.vehicle is not None)
        table = read_table(located, needed, READERS, inputs.signals)
    open_source = source_opener(spec, columns, inputs.signals.dbc, table, speed)
    found = inputs.read_found_model()
    if inputs.vehicle is not None:
        vehicle, observers = read_vehicle(inputs.vehicle), {}
        for held in (True, False):
            stands = Standstills(vehicle=vehicle, stretch=np.zeros(3, dtype=np.int64), brakes=(held,))
            stub = replace(
                _stub_recording(*rig_of(vehicle, brakes=held), "M_z", None), standstills=stands
            )
            observers[held] = factory(stub, found)
        return open_source, CarStandstillEstimator(vehicle, observers, where, adviser)
    nominal = None if inputs.rig is None else read_rig(inputs.rig)
    if table is not None:
        nominal, ground = rig_overridden_by_table(table, nominal), ground or table.ground
    if nominal is None:
        raise InvalidInputError(f"{where}: needs the rig, --rig rig.toml, or --vehicle car.toml")
    rig, tyre = nominal
    if found is not None:
        found.rig_with_k_tolerance(rig, tyre.k, ground)
        if taken := found.ground_used_text(ground):
            print_line(taken)
    estimator = WheelRowEstimator(
        lambda torque: factory(_stub_recording(rig, tyre, torque, ground), found),
        adviser,
        where,
        inputs.signals,
    )
    estimator.range_is_known = rig.range is not None
    if found is not None:
        estimator.weaker, estimator.note = direction_deficit_and_note(
            found.values_for_estimation(ground)
        )
        estimator.loads = None if found.basis is None else found.basis.loads
    return open_source, estimator


def _stub_recording(rig: Rig, tyre: Tyre, torque: str, ground: str | None) -> Recording:
    """A recording that tells a factory what it has to know before there is one."""
    zeros, nothing = np.zeros(3), np.full(3, np.nan)
    return Recording(
        name="live", t=np.arange(3.0), psi=zeros, psi_dot=zeros, F_N=np.ones(3),
        M_z=zeros if torque == "M_z" else nothing, M=zeros, rig=rig, tyre=tyre, ground=ground,
    )  # fmt: skip


def source_opener(
    spec: str, columns: MappedColumns, dbc: Path | None, table: Table | None, speed: float
) -> Callable[[], Source]:
    """What opens a source, again where it is lost; a file, of content `table`, runs at `speed`."""
    kind, _, rest = spec.partition(":")
    if table is not None:
        return lambda: ReplaySource(table, speed)
    if spec == "-":
        return lambda: LineSource(0, columns)
    if kind == "udp":
        address = host_and_port(spec, rest)
        return lambda: UdpSource(address, columns)
    interface, _, channel = rest.partition(":")
    if not interface or not channel:
        raise InvalidInputError(f"{spec}: expected can:INTERFACE:CHANNEL, such as can:socketcan:can0")
    if dbc is None:
        raise InvalidInputError(f"{spec}: --dbc names the database of the bus, such as car.dbc")
    return lambda: CanSource(interface, channel, dbc, columns)
