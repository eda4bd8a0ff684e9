"""Where results come from: version, time, command line, and the inputs with their digests."""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from math import isclose
from pathlib import Path
from typing import Any

from brushgrip.outputs.console import warn
from brushgrip.outputs.verbosity import COMMAND_LINE
from identification.reading.checked_file_reading import require_readable
from identification.reading.rigfile import read_rig
from symbolic import InvalidInputError, rig_from_tables
from symbolic.errors import printable
from symbolic.tables.toml_and_json_parsing import parse_toml
from symbolic.version import version

KEY = "provenance"
"""Where provenance stands in a JSON document."""
_SAME = ("inputs", "rig", "signals", "settings")
"""Fields that two runs share if one may replace the other."""
_WRITTEN = (".json", ".html", ".png")
"""Suffixes of what `diagnose` and `demo` write."""
_MAX_FILE_SIZE = 100_000_000

Provenance = Mapping[str, Any]


def provenance_of(
    inputs: Sequence[Path],
    rig: Path | None = None,
    model: Path | None = None,
    signals: Mapping[str, object] | None = None,
    **settings: object,
) -> dict[str, Any]:
    """The provenance of what is written now.

    Inputs are whatever is read besides rig and model, settings options that change the result.
    """
    return {
        "brushgrip": version(),
        "time_utc": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": ["brushgrip", *map(printable, COMMAND_LINE.get())],
        "inputs": [_file_provenance(path) for path in inputs],
        "rig": None if rig is None else _file_provenance(rig) | {"content": rig.read_text("utf-8-sig")},
        "signals": dict(signals or {}),
        "model": None if model is None else _file_provenance(model),
        "settings": settings,
    }


def digest_of(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def provenance_file(out: Path) -> Path:
    """The file of provenance beside a table of results; `os.devnull` for a pipe or a device."""
    with suppress(OSError):  # Whoever writes to such a name will say so.
        if out.exists() and not out.is_file():
            return Path(os.devnull)
    return out.with_name(f"{out.stem}.{KEY}.json")


def require_same_run(document: Path, provenance: Provenance, *, force: bool) -> tuple[str, ...]:
    """Refuses a folder of another run's results; else files that the same run wrote there."""
    try:
        if not document.is_file() or document.stat().st_size > _MAX_FILE_SIZE:
            return ()
        there = json.loads(document.read_text("utf-8"))[KEY]
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        there = {}
    there = there if isinstance(there, dict) else {}
    plain = json.loads(json.dumps(provenance))
    if not force and any(there.get(key) != plain[key] for key in _SAME):
        when = f" of {there['time_utc']}" if isinstance(there.get("time_utc"), str) else ""
        raise InvalidInputError(
            f"{document.parent}: holds another run{when}; name another folder, or --force replaces it"
        )
    names = there.get("files")
    plain_names = (n for n in names if isinstance(n, str)) if isinstance(names, list) else ()
    return tuple(n for n in plain_names if Path(n).name == n and n not in ("", "..") and n.isprintable())


def labels_model_was_found_from(model: Path, files: Mapping[str, Path]) -> set[str]:
    """Labels of the files that a model was found from, by name and content; none if it tells none."""
    try:
        told = json.loads(model.read_bytes())[KEY]["inputs"]
        known = {(file["name"], file["sha256"]) for file in told}
    except (ValueError, LookupError, TypeError):
        return set()
    return {n for n, path in files.items() if (printable(path.name), digest_of(path)) in known}


def warn_of_another_rig(file: Path | None, model: Path | None) -> None:
    """Warn where a model was found with another half-length or trail than a rig file declares."""
    if file is None or model is None:
        return
    try:
        rig, _ = read_rig(file)
        told = json.loads(model.read_bytes())[KEY]["rig"]["content"]
        found, _ = rig_from_tables(parse_toml(told.encode()))
    except (OSError, ValueError, LookupError, TypeError, AttributeError, InvalidInputError):
        return  # What is wrong with a file is said where it is used.
    if not (isclose(rig.a, found.a) and isclose(rig.e, found.e)):
        warn(
            f"the rig file says a = {rig.a:g} m, e = {rig.e:g} m; the model was found with"
            f" a = {found.a:g} m, e = {found.e:g} m: for the same wheel declare the lengths that it was"
            " found with; for another one diagnose anew, with recordings of it"
        )


def remove_earlier(folder: Path, names: Sequence[str], kept: Sequence[str]) -> None:
    """Remove files of an earlier run, by their plain names; what no run writes stays."""
    for name in names:
        if name not in kept and Path(name).suffix in _WRITTEN and (folder / name).is_file():
            (folder / name).unlink()


def origin_comment(rig: Path, model: Path | None) -> str:
    """A comment in C that says what code was made from; it has no date, so that code stays the same."""
    files = [_file_provenance(path) for path in (rig, model) if path is not None]
    lines = [f"   {file['name']}: SHA-256 {file['sha256']}" for file in files]
    return "\n".join(["/* Made by brushgrip from", *lines, "*/", ""])


def markdown_comment(provenance: Provenance) -> str:
    """Provenance as a comment at the end of a Markdown file, which a page does not show."""
    told = json.dumps({KEY: dict(provenance)}, ensure_ascii=False, indent=2)
    # Nothing in it ends the comment.
    return f"\n<!--\n{told.replace('>', chr(92) + 'u003e')}\n-->\n"


def _file_provenance(path: Path) -> dict[str, Any]:
    require_readable(path)
    return {"name": printable(path.name), "sha256": digest_of(path), "bytes": path.stat().st_size}
