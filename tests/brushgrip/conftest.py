"""A hand-made diagnosis, recordings on disk, and the command as a user calls it."""

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import typer.main

import identification
from brushgrip.cli.app import main
from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.pictures.style import figure_saved_as_png
from brushgrip.report import page
from tests.brushgrip.helpers import PNG, Outcome, Run, Write
from tests.simulated_car import vehicle_text

RIG = "[rig]\na = 0.045\ne = 0.009\n\n[tyre]\nk = 2.4e6\nmu = 1.2\n"


@pytest.fixture(autouse=True, scope="session")
def one_parser() -> Iterator[None]:
    """The parser of all commands, which hundreds of command lines share; else each makes its own."""
    made = typer.main.get_command
    kept = cache(lambda app, _: made(app))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", lambda app: kept(app, len(app.registered_commands)))
        yield


@pytest.fixture
def blank_pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of friction are empty, but in tests that ask for `drawn`."""

    def blank(path: Path, _: object) -> None:
        with figure_saved_as_png(path, 1.0):
            pass

    if "drawn" not in request.fixturenames:
        monkeypatch.setattr("brushgrip.running.estimate_batch.draw_friction", blank)


@pytest.fixture
def drawn() -> None:
    """Has pictures drawn in a module of blank ones."""


@pytest.fixture
def no_drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Empty pictures of a report, for tests of what it says; up to three recordings have residuals."""

    def blank(path: Path, *_: object) -> None:
        path.write_bytes(PNG)

    for name in [name for name in vars(page) if name.startswith("draw_")]:
        monkeypatch.setattr(page, name, blank)
    monkeypatch.setattr(page, "MAX_RECORDINGS", 3)


@pytest.fixture(autouse=True)
def own_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder of its own, and hide the data of this user and machine."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("BRUSHGRIP_DATA", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "user_data"))
    monkeypatch.setenv("COLUMNS", "120")


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Run:
    """Runs the command with arguments."""

    def command(*arguments: object) -> Outcome:
        with pytest.raises(SystemExit) as exit_:
            main([str(argument) for argument in arguments])
        assert isinstance(exit_.value.code, int)
        return Outcome(exit_.value.code, *capfd.readouterr())

    return command


@pytest.fixture
def no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Faults are found before any estimation begins."""

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("work has begun")

    for name in ("diagnose", "identify_free_decay"):
        monkeypatch.setattr(identification, name, refuse)


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(RIG)
    return path


@pytest.fixture
def steering_rig(rig: Path) -> Path:
    """The rig with what a steering torque needs."""
    rig.write_text(RIG.replace("[tyre]", "J_A = 0.15\nb_t = 1.0\n\n[tyre]"))
    return rig


@pytest.fixture
def car(tmp_path: Path) -> Path:
    """The vehicle file of a car without anything optional."""
    path = tmp_path / "car.toml"
    path.write_text(vehicle_text())
    return path


@pytest.fixture
def table() -> dict[str, np.ndarray]:
    """A good recording: one turn to and fro."""
    t = np.arange(60) * 0.01
    psi = 0.2 * np.sin(2 * np.pi * t / 0.6)
    return {"t": t, "psi": psi, "M_z": -7 * np.tanh(20 * psi), "F_N": np.full(60, 400.0)}


@pytest.fixture
def write_csv(tmp_path: Path, table: dict[str, np.ndarray]) -> Write:
    """Writes a recording, with columns replaced or (None) left out, and lines put on top."""

    def write(name: str = "run.csv", columns: Mapping[str, object] | None = None, top: str = "") -> Path:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        chosen = {k: v for k, v in {**table, **(columns or {})}.items() if v is not None}
        rows = zip(*chosen.values(), strict=True)
        lines = [",".join(chosen), *(",".join(str(value) for value in row) for row in rows)]
        path.write_text(top + "\n".join(lines) + "\n")
        return path

    return write


@pytest.fixture(scope="session")
def tracks() -> list[FrictionTrack]:
    """Two observers on each of two recordings; not informed in the first two seconds."""
    t = np.arange(500) * 0.02
    informed = t > 2
    spread = np.where(informed, 0.05, 0.6) * np.exp(-0.1 * t)
    alike = {"t": t, "mu_std": spread, "usable": informed, "usable_share": float(informed.mean())}
    mu, tracks = 1.3 - 0.2 * np.exp(-t), []
    for name, reference in (("held_c", 1.3), ("held_d", None)):
        for label in ("EKF, assumed model", "EKF, model found", "MHE, model found"):
            own = {"name": name, "label": label, "reference": reference}
            tracks.append(FrictionTrack(mu=mu, **own, **alike))
    return tracks
