import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from brushgrip.published import fetch as fetching
from brushgrip.published.fetch import FetchError, fetch, published_files
from symbolic import InvalidInputError
from tests.brushgrip.helpers import serve
from tests.refusal import refused

CONTENT = {"run1.mat": b"first", "run2.mat": b"second", "estimate_run1.csv": b"third"}
URL = "https://example.invalid/commit"


SERVED = {
    f"{URL}/rig/run1.mat": b"first",
    f"{URL}/rig/run2.mat": b"second",
    f"{URL}/estimates/run1.csv": b"third",
}


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


@pytest.fixture(autouse=True)
def no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever a test forgets to replace fails here instead of going out."""
    serve(monkeypatch, {}, Path.write_bytes)
    monkeypatch.setattr(fetching, "RETRIES", 0)
    monkeypatch.delenv("BRUSHGRIP_DATA", raising=False)


@pytest.fixture
def registry(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Three made-up files in place of the published ones; two folders use the same name."""
    lines = [
        f"{name} sha256:{sha256(content)} {url}"
        for (name, content), url in zip(CONTENT.items(), SERVED, strict=True)
    ]
    path = tmp_path_factory.mktemp("registry") / "registry.txt"
    path.write_text("# made up\n" + "\n".join(lines) + "\n")
    monkeypatch.setattr(fetching, "REGISTRY", path)


@pytest.fixture
def local_copy(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Makes a folder of the files, some with other content or (None) left out."""

    def make(**changes: bytes | None) -> Path:
        folder = Path("measured")
        folder.mkdir()
        for name, content in (CONTENT | {f"{k}.mat": v for k, v in changes.items()}).items():
            if content is not None:
                (folder / name).write_bytes(content)
        monkeypatch.setenv("BRUSHGRIP_DATA", str(folder))
        return folder

    return make


def test_what_is_published(tmp_path: Path) -> None:
    published = published_files(tmp_path)
    registry = published.registry

    assert len(registry) == 13 + 13 + 3
    assert sum(name.endswith(".mat") for name in registry) == 13
    assert published.get_url("fem4_ident.mat") == (
        "https://raw.githubusercontent.com/gyorokbendeguz/GyB_TDK_2023/"
        "dd82a2b79db81138d017f91cbf45e8afcfbc5335/SimulationEnv/Old_meas/fem4_ident.mat"
    )
    assert published.get_url("author_estimate_fem4.csv").endswith("/ANN_ErrorPrediction/Data/fem4.csv")
    assert published.get_url("sim_mu_05.csv") == (
        "https://raw.githubusercontent.com/gyorokbendeguz/BSc-Thesis/"
        "02fc92afd2953d63f70f9ecc485552959e782eec/MachineLearning/SimulationResults/sim_mu_05.csv"
    )
    assert all(re.fullmatch("sha256:[0-9a-f]{64}", digest) for digest in registry.values())
    assert len(set(registry.values())) == len(registry)
    assert all(published.get_url(name).startswith("https://") for name in registry)


@pytest.mark.usefixtures("registry")
class TestLocalCopy:
    def test_copies(self, local_copy: Callable[..., Path]) -> None:
        local_copy()
        paths = fetch(Path("out"))

        assert paths == [Path("out") / name for name in CONTENT]
        assert {path.name: path.read_bytes() for path in paths} == CONTENT

    def test_names_what_is_absent_unless_it_stands_beside(self, local_copy: Callable[..., Path]) -> None:
        source = local_copy(run2=None)
        lines: list[str] = []
        paths = fetch(Path("out"), say=lines.append)

        assert [path.name for path in paths] == ["run1.mat", "estimate_run1.csv"]
        assert lines == [f"copied 2 files from {source}", f"absent from {source}: run2.mat"]
        (source.parent / "thesis_simulation").mkdir()
        (source.parent / "thesis_simulation" / "run2.mat").write_bytes(b"second")
        assert len(fetch(Path("out"))) == 3

    def test_into_the_very_folder(self, local_copy: Callable[..., Path]) -> None:
        source = local_copy()

        assert len(fetch(source)) == 3
        assert sorted(path.name for path in source.iterdir()) == sorted(CONTENT)

    def test_wrong_digest(self, local_copy: Callable[..., Path]) -> None:
        source = local_copy(run2=b"tampered")
        message = refused(fetch, Path("out"))
        assert message.startswith(f"{source / 'run2.mat'}: is not the published file: SHA-256 ")
        assert sha256(b"tampered")[:12] in message
        assert sha256(b"second")[:12] in message
        assert "\n" not in message
        assert not Path("out").exists()

    @pytest.mark.parametrize(
        ("name", "fault"),
        [(".", "holds none of the published files"), ("none", "none: is not a folder")],
    )
    def test_no_local_copy(
        self, name: str, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("BRUSHGRIP_DATA", str(tmp_path / name))
        with pytest.raises(InvalidInputError, match=f"^BRUSHGRIP_DATA=.*{fault}"):
            fetch(tmp_path / "out")
        assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("registry")
class TestDownload:
    def test_downloads(self, monkeypatch: pytest.MonkeyPatch) -> None:
        asked = serve(monkeypatch, SERVED, Path.write_bytes)
        lines: list[str] = []
        paths = fetch(Path("out"), say=lines.append)

        assert {path.name: path.read_bytes() for path in paths} == CONTENT
        assert asked == list(SERVED)
        assert lines[0] == "1/3 run1.mat"

    def test_keeps_what_is_whole(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        (tmp_path / "run1.mat").write_bytes(b"first")
        (tmp_path / "run2.mat").write_bytes(b"cut sho")
        asked = serve(monkeypatch, SERVED, Path.write_bytes)
        paths = fetch(tmp_path)

        assert asked == list(SERVED)[1:]
        assert {path.name: path.read_bytes() for path in paths} == CONTENT

    def test_wrong_digest(self, monkeypatch: pytest.MonkeyPatch) -> None:
        serve(monkeypatch, SERVED | {f"{URL}/rig/run2.mat": b"<html>"}, Path.write_bytes)
        with pytest.raises(FetchError, match=r"^run2\.mat: what https.* has not the published"):
            fetch(Path("out"))
        assert list(Path().iterdir()) == []

    def test_a_host_without_end_is_not_heard_out(self, monkeypatch: pytest.MonkeyPatch) -> None:
        given: list[int] = []

        def endless(**_: Any) -> Any:
            def deliver(_url: str, file: Any, _published: Any) -> None:
                while len(given) < 1000:
                    given.append(file.write(bytes(100_000)))

            return deliver

        monkeypatch.setattr(fetching.pooch, "HTTPDownloader", endless)
        with pytest.raises(FetchError, match=r"run1\.mat: cannot be downloaded"):
            fetch(Path("out"))

        assert sum(given) == fetching.MAX_FILE_SIZE
        assert list(Path().iterdir()) == []

    def test_no_network(self) -> None:
        with pytest.raises(FetchError) as caught:
            fetch(Path("out"))

        assert str(caught.value) == (
            f"run1.mat: cannot be downloaded from {URL}/rig/run1.mat (ConnectionError); try again, "
            "or set BRUSHGRIP_DATA to a folder that holds the files"
        )
        assert list(Path().iterdir()) == []


@pytest.mark.measured
def test_published_copy(measured_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BRUSHGRIP_DATA", str(measured_dir))
    paths = fetch(Path("out"))

    assert {path.name for path in measured_dir.glob("*.mat")} <= {path.name for path in paths}
    assert all(path.is_file() for path in paths)
