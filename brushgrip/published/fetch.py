"""The published measurements, downloaded or copied; every file is checked against its digest."""

import errno
import io
import os
import shutil
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import pooch

from brushgrip.inputs.recording_files import LOCAL_COPY
from brushgrip.outputs.atomic import staged_directory
from symbolic import BrushgripError, InvalidInputError

REGISTRY = files("brushgrip.published").joinpath("published.txt")
"""Name, digest and address of every published file, as pooch reads them."""

_SIMULATIONS_BESIDE = "thesis_simulation"
RETRIES = 2
MAX_FILE_SIZE = 20_000_000
"""Size that every published file is below; a download beyond it is cut off [bytes]."""
TIMEOUT = 30.0


class _SizeLimitedFile(io.FileIO):
    def write(self, content: Any) -> int:
        if self.tell() + len(content) > MAX_FILE_SIZE:
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        return super().write(content)


class FetchError(BrushgripError):
    """A download failed; the message names the file and what can be done."""


def published_files(folder: str | Path) -> pooch.Pooch:
    """The registry of the published files, which downloads them into a folder."""
    published = pooch.create(path=folder, base_url="", retry_if_failed=RETRIES)
    with REGISTRY.open(encoding="utf-8") as lines:
        published.load_registry(lines)
    return published


def fetch(destination: str | Path, *, say: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Puts the published files into a folder: all that are available, or none at all.

    Where ``BRUSHGRIP_DATA`` names a folder, files are copied from there and nothing is downloaded;
    those it lacks are named through `say`. Files already in the destination are kept if their digest is
    right; one with a wrong digest is a fault.
    """
    destination = Path(destination)
    local = os.environ.get(LOCAL_COPY)
    with staged_directory(destination) as stage:
        published = published_files(stage)
        if local:
            names = _copy(published, Path(local), say)
        else:
            names = list(published.registry)
            _download(
                published,
                [n for n in names if not _has_published_digest(published, destination / n)],
                say,
            )
    return [destination / name for name in names]


def _copy(published: pooch.Pooch, source: Path, say: Callable[[str], None]) -> list[str]:
    if not source.is_dir():
        raise InvalidInputError(f"{LOCAL_COPY}={source}: is not a folder")
    folders = (source, source.resolve().parent / _SIMULATIONS_BESIDE)
    copied: list[str] = []
    absent: list[str] = []
    for name in published.registry:
        path = next((folder / name for folder in folders if (folder / name).is_file()), None)
        if path is None:
            absent.append(name)
            continue
        if (actual := _digest(path)) != (digest := published.registry[name]):
            raise InvalidInputError(
                f"{path}: is not the published file: SHA-256 {_shortened(actual)}, published "
                f"{_shortened(digest)}; replace or remove it"
            )
        shutil.copyfile(path, published.abspath / name)
        copied.append(name)
    if not copied:
        raise InvalidInputError(
            f"{LOCAL_COPY}={source}: holds none of the published files, such as {absent[0]}; "
            "unset it to download them"
        )
    say(f"copied {len(copied)} files from {source}")
    if absent:
        say(f"absent from {source}: {', '.join(absent)}")
    return copied


def _download(published: pooch.Pooch, names: list[str], say: Callable[[str], None]) -> None:
    pooch.get_logger().setLevel("ERROR")
    for number, name in enumerate(names, start=1):
        say(f"{number}/{len(names)} {name}")
        url = published.get_url(name)
        try:
            published.fetch(name, downloader=download_size_limited)
        except ValueError:
            raise FetchError(
                f"{name}: what {url} delivers has not the published digest "
                f"{_shortened(published.registry[name])}; nothing was kept"
            ) from None
        except OSError as error:  # all of requests' exceptions are OSErrors
            raise FetchError(
                f"{name}: cannot be downloaded from {url} ({type(error).__name__}); try "
                f"again, or set {LOCAL_COPY} to a folder that holds the files"
            ) from None


def download_size_limited(url: str, output_file: str, registry: pooch.Pooch) -> None:
    """Download like pooch's own downloader, but `MAX_FILE_SIZE` at most; checks no digest."""
    with _SizeLimitedFile(output_file, "w") as file:
        pooch.HTTPDownloader(timeout=TIMEOUT)(url, file, registry)


def _has_published_digest(published: pooch.Pooch, path: Path) -> bool:
    return path.is_file() and _digest(path) == published.registry[path.name]


def _digest(path: Path) -> str:
    """The digest of a file, as the registry has it."""
    try:
        return f"sha256:{pooch.file_hash(path, alg='sha256')}"
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read: {error.strerror or error}") from None


def _shortened(digest: str) -> str:
    return f"{digest.removeprefix('sha256:')[:12]}…"
