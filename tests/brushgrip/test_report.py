import base64
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import pytest

from brushgrip.estimation import FrictionTrack
from brushgrip.report import write_report
from identification.results import Diagnosis

Make = Callable[..., Diagnosis]
PNG = b"\x89PNG\r\n\x1a\n"
VOID = {"meta", "img", "link", "br"}


class Page(HTMLParser):
    """Collects text and links, and fails on a tag that is not closed."""

    def __init__(self, text: str) -> None:  # noqa: D107
        super().__init__()
        self.text, self.addresses, self.headings = "", [], []
        self._open: list[str] = []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self._open.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        data = data.replace("\u00a0", " ")
        self.text += data
        if self._open and self._open[-1] in ("h1", "h2"):
            self.headings.append(data)


def written(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def full(
    tmp_path_factory: pytest.TempPathFactory, make_diagnosis: Make, tracks: list[FrictionTrack]
) -> Path:
    """The page of a diagnosis with everything in it."""
    return write_report(tmp_path_factory.mktemp("full"), make_diagnosis(), tracks)


def test_writes_page_and_pictures(full: Path) -> None:
    pictures = [
        *("candidates.png", "experiment_carcass_torsion.png", "friction.png"),
        *("loops.png", "residuals.png", "signatures.png"),
    ]

    assert written(full.parent) == sorted([*pictures, "report.html"])
    for picture in pictures:
        assert (full.parent / picture).read_bytes().startswith(PNG)


def test_page_stands_alone(full: Path) -> None:
    text = full.read_text("utf-8")
    page = Page(text)

    assert len(page.addresses) == 6
    for address in page.addresses:
        head, content = address.split(",")
        assert head == "data:image/png;base64"
        assert base64.b64decode(content).startswith(PNG)
    assert not re.search(r"https?://|url\(|@import|<script", text)


def test_page_says_everything_in_order(full: Path) -> None:
    page = Page(full.read_text("utf-8"))

    assert page.headings == [
        "The declared model misses carcass torsion and torque offset: "
        "held-out error 4.30 % → 2.37 % of range.",
        "Torque errors",
        "Hysteresis loops",
        "Residuals",
        "What the residual follows",
        "Candidates",
        "Effects found",
        "Next experiments",
        "Friction over time",
        "What remains unexplained",
    ]
    assert "Before any effect is tried: The residual follows " in page.text
    assert "Sweep to and fro, 10 s: carcass torsion and patch width then differ" in page.text
    assert "k_t = 391.2 ± 4.2 N m/rad" in page.text
    assert "These recordings cannot tell carcass torsion from patch width." in page.text
    assert "Follows psi_dot <by> 0.4 & F_N." in page.text


def test_a_recording_that_got_worse_is_marked_and_tracks_may_be_absent(
    tmp_path: Path, make_diagnosis: Make
) -> None:
    text = write_report(tmp_path, make_diagnosis(worse=("held_d",))).read_text("utf-8")

    marked = [row for row in re.findall(r"<tr.*?</tr>", text) if "▲ worse" in row]
    assert len(marked) == 1
    assert "held_d" in marked[0]
    assert "<li>held_d got worse</li>" in text
    assert "Friction over time" not in text
    assert "friction.png" not in written(tmp_path)


def test_names_are_escaped(tmp_path: Path, make_diagnosis: Make) -> None:
    diagnosis = make_diagnosis(training=(r"<b>$x_1\frac$</b>",), holdout=())
    page = Page(write_report(tmp_path, diagnosis).read_text("utf-8"))

    assert r"<b>$x_1\frac$</b>" in page.text


@pytest.mark.parametrize(("training", "holdout"), [(1, 0), (2, 0), (1, 1), (9, 4)])
def test_any_number_of_recordings(
    tmp_path: Path, make_diagnosis: Make, training: int, holdout: int
) -> None:
    diagnosis = make_diagnosis(
        training=tuple(f"train_{i}" for i in range(training)),
        holdout=tuple(f"held_{i}" for i in range(holdout)),
        found=training != 2,
        unexplained=False,
    )
    page = Page(write_report(tmp_path, diagnosis).read_text("utf-8"))

    for name in (*diagnosis.recordings, *diagnosis.holdout):
        assert name in page.text


def test_same_diagnosis_same_page_and_no_global_state(
    full: Path, tmp_path: Path, make_diagnosis: Make, tracks: list[FrictionTrack]
) -> None:
    before = dict(matplotlib.rcParams)
    again = write_report(tmp_path, make_diagnosis(), tracks)

    assert again.read_bytes() == full.read_bytes()
    assert dict(matplotlib.rcParams) == before
