"""The friction damper's runs: joined from published arrays, or copied, and checked by their values."""

import json
from pathlib import Path

import numpy as np
import pytest

from brushgrip.cli.app import main
from brushgrip.published import friction_damper
from brushgrip.published.fetch import FetchError
from brushgrip.published.friction_damper import (
    CHANNELS,
    EARTHQUAKES,
    HARMONIC,
    address_and_digests,
    channels_digest,
)
from symbolic import InvalidInputError
from tests.brushgrip.helpers import serve

ADDRESS = "https://example.invalid/commit/data set"
RNG = np.random.default_rng(3)
RUNS = {
    "harmonic_00": {"t": np.arange(50) / 1024} | {c: RNG.standard_normal(50) for c in "Fxv"},
    "earthquake_DuzceMCE": {c: RNG.standard_normal(40) for c in CHANNELS},
}
SERVED = {f"{ADDRESS}/{c}/test0.npy": RUNS["harmonic_00"][c][:, None] for c in "Fxv"} | {
    f"{ADDRESS}/validation/DuzceMCE.npy": np.column_stack(list(RUNS["earthquake_DuzceMCE"].values()))
}


@pytest.fixture(autouse=True)
def served(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, np.ndarray]:
    """Made-up runs and a server of them in place of the published ones."""
    contents = dict(SERVED)

    def save(path: Path, array: np.ndarray) -> None:
        with path.open("wb") as file:
            np.save(file, array)

    serve(monkeypatch, contents, save)
    registry = tmp_path / "registry.txt"
    rows = [f"{name} {channels_digest(channels)}" for name, channels in RUNS.items()]
    registry.write_text("\n".join(["# made up", ADDRESS, *rows]) + "\n")
    monkeypatch.setattr(friction_damper, "REGISTRY", registry)
    monkeypatch.setattr(friction_damper, "RETRIES", 0)
    monkeypatch.delenv("BRUSHGRIP_DATA", raising=False)
    return contents


def fetched(out: Path) -> list[str]:
    lines: list[str] = []
    paths = friction_damper.fetch_friction_damper(out, say=lines.append)
    for path, (name, channels) in zip(paths, RUNS.items(), strict=True):
        assert path == out / f"{name}.npz"
        with np.load(path) as arrays:
            assert list(arrays) == list(CHANNELS)
            assert all(np.array_equal(arrays[c], channels[c]) for c in CHANNELS)
    assert sorted(p.name for p in out.iterdir()) == sorted(p.name for p in paths)
    return lines


def test_what_is_published(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    address, published = address_and_digests(friction_damper.REGISTRY)

    assert tuple(published) == (*HARMONIC, *EARTHQUAKES)
    assert len(set(published.values())) == 15
    assert "/87ff68863012d251e38fd423d86f9253b3902ee8/" in address


def test_runs_are_joined_and_kept(served: dict[str, np.ndarray]) -> None:
    lines = fetched(Path("out"))
    assert "CC BY-SA 4.0" in lines[0]
    assert lines[1:] == ["1/2 harmonic_00", "2/2 earthquake_DuzceMCE"]

    served.clear()
    assert len(fetched(Path("out"))) == 1, "nothing is downloaded again"


def test_other_values_and_no_network_are_named(served: dict[str, np.ndarray]) -> None:
    served[f"{ADDRESS}/x/test0.npy"] = served[f"{ADDRESS}/x/test0.npy"] + 1e-9

    with pytest.raises(FetchError, match=r"harmonic_00: the values from .* are not the published ones"):
        friction_damper.fetch_friction_damper(Path("out"))
    assert not Path("out").exists()
    served.clear()
    with pytest.raises(FetchError, match=r"F/test0.npy: cannot be downloaded \(ConnectionError\)"):
        friction_damper.fetch_friction_damper(Path("out"))


def test_runs_beside_a_local_copy(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("measured").mkdir()
    Path("second_rig").mkdir()
    monkeypatch.setenv("BRUSHGRIP_DATA", str(Path("measured")))
    with pytest.raises(InvalidInputError, match=r"holds no harmonic_00.npz, nor does .*second_rig"):
        fetched(Path("out"))
    for name, channels in RUNS.items():
        np.savez(Path(f"second_rig/{name}.npz"), **channels)

    fetched(Path("out"))

    path = Path("second_rig/harmonic_00.npz")
    whole = path.read_bytes()
    damaged = whole.replace(b"descr", b"\xff" * 5)
    for content in (b"no archive", b"", whole[:-30], whole[:60], damaged):
        path.write_bytes(content)
        said = r"harmonic_00.npz: is no run of the friction damper"
        with pytest.raises(InvalidInputError, match=said):
            fetched(Path("elsewhere"))


@pytest.mark.parametrize("shape", [(), (7, 3), (0,), (5, 4, 2)])
def test_arrays_of_another_shape_are_refused(
    shape: tuple[int, ...], served: dict[str, np.ndarray]
) -> None:
    served[f"{ADDRESS}/validation/DuzceMCE.npy"] = np.ones(shape)

    with pytest.raises(FetchError, match=r"DuzceMCE"):
        friction_damper.fetch_friction_damper(Path("out"))


@pytest.mark.parametrize(
    ("name", "place", "columns"),
    [
        ("tension_25lb_0.5Hz", "dataset-1/characterization datasets/0.5Hz25lbtension", 6),
        ("step0.03ea1forward", "dataset-4/step0.03ea1forward", 8),
    ],
)
def test_inches_and_kips(name: str, place: str, columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    address, published = address_and_digests(friction_damper.PULLED_REGISTRY)
    assert tuple(published) == (*friction_damper.CONSTANT, *friction_damper.CHANGED)
    assert address.endswith("/0e09aa9d950760277e31c08cd93fd01f39a5af09")
    table = RNG.standard_normal((30, columns))
    SI = (table[:, :4] * [1, 0.0254, 4448.2216152605, 0.0254]).astype(np.float32).astype(float)
    channels = dict(zip("txFv", SI.T, strict=True))
    Path("runs.txt").write_text(f"{ADDRESS}\n{name} {channels_digest(channels)}\n")
    monkeypatch.setattr(friction_damper, "PULLED_REGISTRY", Path("runs.txt"))
    content = json.dumps({"data": table.tolist()})
    address = f"{ADDRESS}/data/{place}.json"
    serve(monkeypatch, {address: content}, lambda path, text: path.write_text(text))

    (path,) = friction_damper.fetch_changed_friction(Path("out"))

    with np.load(path) as arrays:
        assert all(np.array_equal(arrays[c], channels[c]) for c in "txFv")


def test_the_command_names_the_licence(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["fetch", "friction-damper", "--out", str(Path("out"))])

    shown = capsys.readouterr()
    assert "CC BY-SA 4.0" in shown.out + shown.err
    assert "2 files in" in shown.out + shown.err
