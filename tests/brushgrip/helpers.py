"""What the suites of this folder share: the outcome of a command, files before and after, tables."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar
from urllib.parse import unquote

import numpy as np
import pooch
import pytest

from brushgrip.cli.app import LISTS

Content = TypeVar("Content")
PNG = b"\x89PNG\r\n\x1a\n"


class Outcome(NamedTuple):
    """Result of a command: exit status, standard output, standard error."""

    status: int
    out: str
    err: str

    def refused(self, *words: str, status: int = 2) -> None:
        """Nothing was printed but one line on what is wrong, in which these words stand."""
        assert (self.status, self.out) == (status, ""), self
        assert self.err.count("\n") == 1, self.err
        assert self.err.endswith("\n")
        for word in words:
            assert word in self.err


Run = Callable[..., Outcome]
Write = Callable[..., Path]


def with_defaults(defaults: Sequence[object], given: Sequence[object]) -> list[object]:
    """Options of one value each that are not given again, but for lists, then what is given."""
    pairs = [defaults[i : i + 2] for i in range(0, len(defaults), 2)]
    return [
        *(word for pair in pairs if pair[0] in LISTS or pair[0] not in given for word in pair),
        *given,
    ]


def write_model(values: Mapping[str, float] | None = None, **content: object) -> Path:
    """The file model.json of k = 2.4e6 N/m^2 and of effects by `effect.parameter`, with more content."""
    tyre = {"k": 2.4e6, **(values or {})}
    effects = list(dict.fromkeys(name.partition(".")[0] for name in tyre if "." in name))
    usual = {"version": 1, "effects": effects, "shared": tyre, "recordings": {}}
    path = Path("model.json").resolve()
    path.write_text(json.dumps(usual | content))
    return path


def contents(folder: Path) -> dict[str, bytes | None]:
    """Every file below a folder, and (None) every folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


def table_of(path: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV file by their names; an empty field is NaN."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: table[name] for name in table.dtype.names}


def serve(
    monkeypatch: pytest.MonkeyPatch,
    contents: Mapping[str, Content],
    write: Callable[[Path, Content], object],
) -> list[str]:
    """Lets pooch download from a mapping of addresses alone; returns the list of addresses asked for."""
    asked: list[str] = []

    def downloader(**_: Any) -> Callable[..., None]:
        def deliver(url: str, output_file: Any, _: Any) -> None:
            asked.append(url)
            if unquote(url) not in contents:
                raise ConnectionError(url)
            write(Path(output_file.name), contents[unquote(url)])

        return deliver

    monkeypatch.setattr(pooch, "HTTPDownloader", downloader)
    return asked
