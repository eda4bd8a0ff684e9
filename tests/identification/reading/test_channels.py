"""Channels with clocks of their own on one clock, and names that are resolved."""

from pathlib import Path

import numpy as np
import pytest

from identification.reading.channels import ChannelFile, Samples, resolve
from identification.reading.clock import tabulate
from identification.reading.signal_map import NO_MAP
from identification.reading.table import REQUIRED_COLUMNS, Table, require_valid_samples
from symbolic import InvalidInputError

PATH = Path("run.mf4")


def table_of(**channels: Samples) -> Table:
    file = ChannelFile(names=list(channels), read=channels.__getitem__)
    return tabulate(PATH, file, REQUIRED_COLUMNS, NO_MAP)


def checked(**channels: Samples) -> None:
    require_valid_samples(table_of(**channels), REQUIRED_COLUMNS)


def line(start: float, step: float, size: int, slope: float = 1.0) -> Samples:
    times = start + step * np.arange(size)
    return Samples(values=slope * times, times=times)


def test_a_slower_angle_is_interpolated_at_the_torque() -> None:
    columns = table_of(psi=line(5, 0.02, 60), M_z=line(5.003, 0.01, 100), F_N=line(5, 0.1, 12)).columns

    np.testing.assert_allclose(columns["t"], 0.01 * np.arange(100), atol=1e-12)
    np.testing.assert_allclose(columns["psi"], columns["M_z"], rtol=1e-12)
    np.testing.assert_allclose(columns["F_N"], columns["M_z"], rtol=1e-12)


def test_no_torque_is_made_up_where_the_angle_is_faster() -> None:
    columns = table_of(psi=line(0, 0.01, 101), M_z=line(0, 0.1, 11), F_N=line(0, 0.1, 11)).columns

    assert columns["t"].size == 101
    assert np.isfinite(columns["M_z"]).sum() == 11
    np.testing.assert_allclose(columns["psi"], columns["t"], atol=1e-12)


def test_a_gap_is_not_bridged() -> None:
    angle = line(0, 0.01, 100)
    keep = np.abs(np.asarray(angle.times) - 0.5) > 0.1
    with_gap = Samples(values=angle.values[keep], times=np.asarray(angle.times)[keep])
    columns = table_of(psi=with_gap, M_z=line(0, 0.01, 100), F_N=line(0, 0.01, 100)).columns

    inside = np.abs(columns["t"] - 0.5) < 0.09
    assert np.isnan(columns["psi"][inside]).all()
    assert np.isfinite(columns["psi"][np.abs(columns["t"] - 0.5) > 0.12]).all()


def test_times_that_run_backwards_are_a_fault() -> None:
    back = Samples(values=np.zeros(3), times=np.array([0.0, 2.0, 1.0]))
    with pytest.raises(InvalidInputError, match="the times of M_z must increase"):
        table_of(psi=line(0, 1, 3), M_z=back, F_N=line(0, 1, 3))


def test_lengths_must_agree_without_clocks() -> None:
    with pytest.raises(InvalidInputError, match="M_z holds 2 samples, t holds 3"):
        checked(
            t=Samples(values=np.arange(3.0)), psi=Samples(values=np.zeros(3)),
            M_z=Samples(values=np.zeros(2)), F_N=Samples(values=np.ones(3)),
        )  # fmt: skip


def test_names_are_resolved_by_their_last_part_or_asked_for() -> None:
    names = ["Rig/Angle [deg]", "Rig/Mz", "Car/Mz"]
    assert resolve("run.mf4", "Angle", names) == "Rig/Angle [deg]"
    assert resolve("run.mf4", "Car/Mz", names) == "Car/Mz"
    assert resolve("run.mf4", "z", names) is None
    with pytest.raises(InvalidInputError, match="'Mz' may be Rig/Mz, Car/Mz"):
        resolve("run.mf4", "Mz", names)
