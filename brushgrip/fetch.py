"""The published measurements, downloaded or copied, every file held against its digest."""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pooch

from brushgrip.atomic import staged_directory
from brushgrip.digests import PUBLICATIONS
from symbolic import BrushgripError, InvalidInputError

LOCAL_COPY = "BRUSHGRIP_DATA"
"""Environment variable that names a folder with the published files."""

_SIMULATIONS_BESIDE = "thesis_simulation"
_RETRIES = 2
_TIMEOUT = 30.0


class FetchError(BrushgripError):
    """A download failed; the message names the file and what can be done."""


class PublishedFile(NamedTuple):
    """A published file: the name it is saved under, its address and its SHA-256."""

    name: str
    url: str
    sha256: str


def published_files() -> list[PublishedFile]:
    """Everything that `fetch` knows of."""
    return [
        PublishedFile(publication.prefix + name, f"{publication.url}/{name}", sha256)
        for publication in PUBLICATIONS
        for name, sha256 in publication.digests.items()
    ]


def fetch(destination: str | Path, *, say: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Puts the published files into a folder; all that are to be had, or none at all.

    Where ``BRUSHGRIP_DATA`` names a folder, files are copied from there and nothing is downloaded;
    those it lacks are named through `say`. Files already in the destination are kept if whole.

    Args:
        destination: the folder, made if missing.
        say: takes one line of progress at a time.

    Returns:
        The files now in the folder, in the order of publication.

    Raises:
        InvalidInputError: the destination cannot be written, ``BRUSHGRIP_DATA`` holds none of the
            files, or one with a wrong digest.
        FetchError: a download failed.
    """
    destination = Path(destination)
    local = os.environ.get(LOCAL_COPY)
    with staged_directory(destination) as stage:
        if local:
            files = _copy(Path(local), stage, say)
        else:
            files = published_files()
            _download([file for file in files if not _is_whole(destination, file)], stage, say)
    return [destination / file.name for file in files]


def _copy(source: Path, stage: Path, say: Callable[[str], None]) -> list[PublishedFile]:
    if not source.is_dir():
        raise InvalidInputError(f"{LOCAL_COPY}={source}: is not a folder")
    folders = (source, source.resolve().parent / _SIMULATIONS_BESIDE)
    found: list[PublishedFile] = []
    absent: list[str] = []
    for file in published_files():
        path = next((f / file.name for f in folders if (f / file.name).is_file()), None)
        if path is None:
            absent.append(file.name)
            continue
        _require_digest(path, file.sha256)
        shutil.copyfile(path, stage / file.name)
        found.append(file)
    if not found:
        raise InvalidInputError(
            f"{LOCAL_COPY}={source}: holds none of the published files, such as {absent[0]}; "
            "unset it to download them"
        )
    say(f"copied {len(found)} files from {source}")
    if absent:
        say(f"absent from {source}: {', '.join(absent)}")
    return found


def _download(files: list[PublishedFile], stage: Path, say: Callable[[str], None]) -> None:
    pooch.get_logger().setLevel("ERROR")
    registry = pooch.create(
        path=stage,
        base_url="",
        registry={file.name: f"sha256:{file.sha256}" for file in files},
        urls={file.name: file.url for file in files},
        retry_if_failed=_RETRIES,
    )
    for number, file in enumerate(files, start=1):
        say(f"{number}/{len(files)} {file.name}")
        try:
            registry.fetch(file.name, downloader=pooch.HTTPDownloader(timeout=_TIMEOUT))
        except ValueError:
            raise FetchError(
                f"{file.name}: what {file.url} delivers has not the published digest "
                f"{file.sha256[:12]}…; nothing was kept"
            ) from None
        except OSError as error:  # all of requests' exceptions are OSErrors
            raise FetchError(
                f"{file.name}: cannot be downloaded from {file.url} ({type(error).__name__}); try "
                f"again, or set {LOCAL_COPY} to a folder that holds the files"
            ) from None


def _is_whole(folder: Path, file: PublishedFile) -> bool:
    path = folder / file.name
    return path.is_file() and _digest(path) == file.sha256


def _require_digest(path: Path, sha256: str) -> None:
    found = _digest(path)
    if found != sha256:
        raise InvalidInputError(
            f"{path}: is not the published file: SHA-256 {found[:12]}…, published {sha256[:12]}…; "
            "replace or remove it"
        )


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read: {error.strerror or error}") from None
