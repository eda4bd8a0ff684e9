import base64
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import pytest

from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.pictures.diagnosis import draw_residual_correlations
from brushgrip.report import page as report
from brushgrip.report import tables
from brushgrip.report.friction_summary import has_unusable_gap
from brushgrip.report.friction_verdict import CARE, NOT_YET, NOTHING, USE
from brushgrip.report.page import write_report
from brushgrip.report.print_diagnosis_and_fits import rejected_user_effects
from identification import Diagnosis, ParameterEstimate, SelectionCriteria
from identification.diagnosis.result_parts import Candidate
from identification.residuals.full_slide_repeatability import Repeatability
from identification.selection.trial_runner import worker_submitter
from tests.brushgrip.factories import TRACKS, make_diagnosis, make_outcome, signatures

VERDICTS = (USE, CARE, NOT_YET, NOTHING)
VOID = {"meta", "img", "link", "br", "input"}


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
def full(tmp_path_factory: pytest.TempPathFactory, tracks: list[FrictionTrack]) -> Path:
    """The page of a diagnosis with everything in it."""
    return write_report(tmp_path_factory.mktemp("full"), make_diagnosis(), tracks)


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("c = 1.20 ± 0.05, 49 % of it", "c = 1.20~±~0.05, 49~% of it"),
        ("(± 0.41 to 0.45)", "(±~0.41 to 0.45)"),
        ("before [N m]", "before [N~m]"),
        ("388.2 N m/rad at 10⁶ N/m² and 2 ms", "388.2~N~m/rad at 10⁶~N/m² and 2 ms"),
        ("parameters ± standard deviation", "parameters ± standard deviation"),
    ],
)
def test_a_figure_stays_on_its_line_and_a_heading_breaks(text: str, kept: str) -> None:
    assert report._with_nonbreaking_units(text).replace("\u00a0", "~") == kept


def test_a_correlation_of_nothing_has_no_sign() -> None:
    strong = signatures(0.8).signatures
    assert [tables._correlation_cell(s) for s in strong[:2]] == ["+0.80* (0.30)", "−0.80* (0.30)"]
    assert {tables._correlation_cell(s) for s in signatures(0.004).signatures} == {"0.00 (0.30)"}


def test_a_pale_line_is_spoken_of_where_there_is_one() -> None:
    outcome = make_outcome(tracks=TRACKS[:1])
    assert not has_unusable_gap(outcome)
    assert has_unusable_gap(replace(outcome, tracks=TRACKS[:2]))


def text_of(diagnosis: Diagnosis) -> str:
    """The text of a page, with single spaces."""
    return " ".join(Page(write_report(Path(), diagnosis).read_text("utf-8")).text.split())


def test_page_stands_alone(full: Path) -> None:
    text = full.read_text("utf-8")
    page = Page(text)

    pictures = [address for address in page.addresses if not address.startswith("#")]
    assert len(pictures) == 7
    for address in pictures:
        head, content = address.split(",")
        assert head == "data:image/svg+xml;base64"
        assert b"<svg" in base64.b64decode(content)[:1000]
    assert not re.search(r"https?://|url\(|@import|<script", text)


def test_every_link_of_the_contents_leads_somewhere(full: Path) -> None:
    text = full.read_text("utf-8")
    links = set(re.findall(r'href="#(\w+)"', text))
    assert links >= {"errors", "effects", "experiments", "tracks", "glossary"}
    assert links <= set(re.findall(r'id="(\w+)"', text))


def test_words_of_statistics_are_explained(full: Path) -> None:
    text = full.read_text("utf-8")
    explained = set(re.findall(r"<dt>([^<]+)</dt>", text))

    assert explained >= {"autocorrelation", "correlation", "collinear", "residual", "ΔBIC"}


@pytest.mark.usefixtures("no_drawing")
def test_pictures_that_are_not_drawn_as_lines_are_points() -> None:
    page = Page(write_report(Path(), make_diagnosis()).read_text("utf-8"))
    (head,) = {a.split(",")[0] for a in page.addresses if not a.startswith("#")}
    assert head == "data:image/png;base64"


def test_page_says_everything_in_order(full: Path) -> None:
    page = Page(full.read_text("utf-8"))

    assert page.headings == [
        "What the assumed model leaves out: (a) The tyre's body yields, or its pressure is spread"
        " otherwise (likely, not proven). (b) The torque channel has a zero error: −0.12 N m (likely,"
        " not proven). (c) An error beyond noise remains, of unknown cause, which the model found leaves"
        " out too.",
        "Before you act on it",
        "Contents",
        "What was found",
        "Friction over time",
        "Mechanisms",
        "Torque errors",
        "Hysteresis loops",
        "Residuals",
        "What the residual follows",
        "Candidates",
        "Effects found",
        "Next recording",
        "What remains unexplained",
        "Glossary",
    ]
    assert "Refitted: The residual follows " in page.text
    assert "A: Sweep to and fro, 10 s: carcass torsion and patch width then differ" in page.text
    assert "k_t = 391.2 ± 4.2 N m/rad" in page.text
    assert "Follows psi_dot <by> 0.4 & F_N." in page.text


@pytest.mark.usefixtures("no_drawing")
def test_the_first_screen_says_what_friction_is() -> None:
    outcome = make_outcome("c", tracks=TRACKS, grounds={"ice": ("a", "b", "c", "d")})
    text = write_report(Path(), make_diagnosis(("a", "b", "d"), ("c",)), (), outcome).read_text("utf-8")
    page = Page(text)
    first, rest = page.text.split("What was found\n\n", 1)

    assert "1.20 ± 0.10" in first
    assert "Valid for: A wheel that stands and is steered" in first
    assert "not for driving speed" in first
    assert "In 1 recording to which no shared value was fitted, but by" in first
    assert ", 4.30 % with only k fitted, 2.37 % by the model found." in first
    assert (
        "friction and torque offset, and lengths and load within their tolerances, fitted to each"
        in first
    )
    assert "Simulated" not in first
    assert "the bar beside its last one is the 95 % band of the recording" in first
    assert "never: it has not slid enough to tell" in first
    assert "friction in b after 7.0 s" in first
    assert "Share of the informed samples whose 95 % band holds the friction that was" in rest
    assert page.text.count("friction between tyre and ground 1.10") == 2, "title and heading"
    assert "It stands on 3 recordings, 1 validation recording judged it" in rest
    assert page.headings[0].startswith(
        "Use it with care: friction between tyre and ground 1.10 ± 0.10 (b)"
    )
    assert page.headings[1:4] == ["Before you act on it", "Contents", "What was found"]
    assert (
        "<title>Use it with care: friction between tyre and ground 1.10 ± 0.10 (b)".replace(
            " ± ", "\u00a0±\u00a0"
        )
        in text
    )


@pytest.mark.usefixtures("no_drawing")
def test_each_verdict_has_its_colour_and_repeatability_stands_with_the_errors() -> None:
    known = Repeatability(replicates=(("a", "b"),), spread=0.048, nrmse=0.013)
    diagnosis = replace(make_diagnosis(("a", "b", "d"), ("c",)), repeatability=known)
    outcome = make_outcome("c", tracks=TRACKS, grounds={"ice": ("a", "b", "c", "d")})
    text = write_report(Path(), diagnosis, (), outcome).read_text("utf-8")
    colours: dict[str, str] = {}
    for rule in re.findall(r"(\[data-verdict.*?) \{ border-left-color: (.*?); \}", text):
        colours |= dict.fromkeys(re.findall(r'"(.*?)"', rule[0]), rule[1])

    told = [[c for start, c in colours.items() if one.startswith(start)] for one in VERDICTS]
    assert told == [["var(--use)"], ["var(--care)"], ["var(--not-yet)"], ["var(--not-yet)"]]
    assert f'<div class="summary" data-verdict="{CARE}">' in text
    first, rest = Page(text).text.split("What was found\n\n", 1)
    assert "“a” and “b” by 4.80 %" in rest
    assert "“a” and “b”" not in first


def test_on_a_narrow_screen_every_cell_has_its_heading(full: Path) -> None:
    text = full.read_text("utf-8")
    for table in re.findall(r"<table.*?</table>", text, re.DOTALL):
        headings = re.findall(r"<th scope=\"col\"[^>]*>(.*?)</th>", table)
        for row in re.findall(r"<tr>\n?<th scope=\"row\".*?</tr>", table, re.DOTALL):
            assert re.findall(r'<td[^>]*data-heading="(.*?)"', row) == headings[1:]


@pytest.mark.usefixtures("no_drawing")
def test_a_recording_that_got_worse_is_marked_and_tracks_may_be_absent() -> None:
    text = write_report(Path(), make_diagnosis(worse=("held_d",))).read_text("utf-8")

    marked = [row for row in re.findall(r"<tr.*?</tr>", text) if "▲ worse" in row]
    assert len(marked) == 1
    assert "held_d" in marked[0]
    assert "<li>held_d got worse</li>" in text
    assert "Friction over time" not in text
    assert "friction.png" not in written(Path())


@pytest.mark.usefixtures("no_drawing")
@pytest.mark.parametrize(
    ("training", "holdout", "words"),
    [
        (1, 0, "1 recording for training (train_0), none for validation: with a single recording the"),
        (5, 0, "5 recordings for training, none for validation: each was left out in turn to judge."),
        (
            2,
            1,
            "2 recordings for training (train_0 and train_1), 1 for validation (held_0), by whose errors"
            " every candidate and the result are judged.",
        ),
    ],
)
def test_page_says_what_judges(training: int, holdout: int, words: str) -> None:
    names = tuple(f"train_{i}" for i in range(training)), tuple(f"held_{i}" for i in range(holdout))

    assert words in text_of(make_diagnosis(*names))


@pytest.mark.usefixtures("no_drawing")
def test_page_says_of_which_recordings_residuals_are_shown() -> None:
    room = "There is room for 3 of 5 recordings (chosen first: those for validation)."
    assert room in text_of(make_diagnosis())
    assert "There is room" not in text_of(make_diagnosis(holdout=("held_c",)))
    names = ("train_a", "train_b", "train_c", "train_d")
    assert "(chosen first: a typical one)" in text_of(make_diagnosis(names, ()))


@pytest.mark.usefixtures("no_drawing")
def test_page_gives_the_thresholds_of_the_search() -> None:
    diagnosis = make_diagnosis()
    assert "ΔBIC below zero supports the effect." in text_of(diagnosis)
    criteria = SelectionCriteria(strong=6.0)
    text = text_of(replace(diagnosis, criteria=criteria))

    assert criteria.clear != criteria.strong
    assert f"up to {criteria.strong:g} is accepted where the error of validation" in text
    assert f"falls by more than {criteria.clear:g} standard errors" in text


def test_signatures_before_and_after_are_not_mixed_up(full: Path) -> None:
    diagnosis = make_diagnosis()
    before, after = diagnosis.signatures_before, diagnosis.signatures_after
    draw_residual_correlations(Path("signatures.png"), before, after)
    text = Page(full.read_text("utf-8")).text

    assert before.summary_paragraph != after.summary_paragraph
    assert f"Refitted: {before.summary_paragraph}" in text
    assert f"Found: {after.summary_paragraph}" in text
    assert (full.parent / "signatures.png").read_bytes() == Path("signatures.png").read_bytes()


@pytest.mark.long
@pytest.mark.parametrize(
    ("training", "holdout"),
    [
        pytest.param(1, 0, marks=pytest.mark.long),
        (1, 1),
        pytest.param(2, 0, marks=pytest.mark.long),
        pytest.param(9, 4, marks=pytest.mark.long),
    ],
)
def test_any_number_of_recordings_of_any_name(training: int, holdout: int) -> None:
    diagnosis = make_diagnosis(
        training=tuple(rf"<b>$x_{i}\frac$</b>" for i in range(training)),
        holdout=tuple(f"held & {i}" for i in range(holdout)),
        found=training != 2,
        unexplained=False,
    )
    page = Page(write_report(Path(), diagnosis).read_text("utf-8"))

    for name in (*diagnosis.recordings, *diagnosis.holdout):
        assert name in page.text


@pytest.mark.long
def test_the_same_diagnosis_makes_the_same_page_in_processes_too(
    full: Path, tracks: list[FrictionTrack]
) -> None:
    before = dict(matplotlib.rcParams)
    write_report(Path(), make_diagnosis(), tracks)
    assert dict(matplotlib.rcParams) == before
    with worker_submitter(2) as submit:
        again = write_report(Path(), make_diagnosis(), tracks, submit=submit)

    for path in full.parent.iterdir():
        assert (again.parent / path.name).read_bytes() == path.read_bytes()


def test_an_own_effect_that_was_not_added_is_told_with_its_value_and_gain() -> None:
    diagnosis = make_diagnosis(("a", "b"), ("c",))
    c = ParameterEstimate(value=12.3, std=4.5, unit="N m/rad^3")
    boot = Candidate(
        name="boot_spring", summary="a boot", holdout_nrmse=0.029, delta_bic=3.2, parameters={"c": c}
    )
    (line,) = rejected_user_effects(replace(diagnosis, candidates=(*diagnosis.candidates, boot)))

    assert rejected_user_effects(diagnosis) == []
    assert line.startswith(
        "boot spring, of your own, was not added. In the refitted model, without the effects found:"
        " c = 12.3 ± 4.5 N m/rad³; error "
    )
    ended = replace(boot, at_bound=("c",))
    (line_at_end,) = rejected_user_effects(replace(diagnosis, candidates=(ended,)))
    assert "found: c = 12.3 N m/rad³ (at the end of its range); error " in line_at_end
    assert any(
        "(at the end" in row[2]
        for row in tables.candidates_table(replace(diagnosis, candidates=(ended,))).rows
    )
    assert line.endswith("→ 2.90 % of range with it alone, ΔBIC +3.2; alone not worth its parameters")


def test_the_command_is_told_without_the_folders_of_its_files() -> None:
    rig, source = {"name": "rig.toml", "sha256": ""}, {"name": "run 1.csv", "sha256": ""}
    command = [
        *("brushgrip", "diagnose", "/data/secret/run 1.csv", "--rig", "data/rig.toml"),
        *(
            "--ground=ice=../a,C:\\me\\b.csv",
            "--map",
            "psi=1/15*Angle:deg,M_z=-Mz",
            "--out",
            "/data/x/out/",
        ),
    ]
    made = {"inputs": [source], "rig": rig, "model": None, "command": command}

    assert tables.command_line(made) == (
        "brushgrip diagnose run 1.csv --rig rig.toml --ground=ice=a,b.csv"
        " --map psi=1/15*Angle:deg,M_z=-Mz --out out"
    )
