"""What the suites of this folder share: the outcome of a command, files before and after, tables."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np


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
