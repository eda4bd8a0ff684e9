"""The code on the pages runs: Python blocks and commands, in the order of the page."""

import importlib
import re
import shlex
import shutil
from inspect import isfunction
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brushgrip import main
from observers import Estimate, Status
from symbolic import Effect, Model, simulate
from symbolic.effects.library import KNOWN
from tests.brushgrip.helpers import table_of
from tests.columns import write_columns
from tests.simulated_car import SimulatedCar, steering, vehicle_text

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```", re.MULTILINE | re.DOTALL)
PRINTED = re.compile(r"^prints\n\n```text\n(.*?)^```", re.MULTILINE | re.DOTALL)
QUICK = ["README.md", "docs/start/controller.md", "docs/start/own_data.md", "docs/understand/effects.md"]
WHOLE = ["docs/start/ecu.md", "docs/start/least_steering.md", "docs/start/own_recording.md"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for path in (ROOT / "examples" / "recordings").iterdir():
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("page", [*QUICK, *(pytest.param(p, marks=pytest.mark.long) for p in WHOLE)])
@pytest.mark.usefixtures("folder")
def test_the_code_of_a_page_runs(page, capsys):
    text = (ROOT / page).read_text(encoding="utf-8")
    names = {}
    blocks = BLOCK.findall(text)
    assert blocks
    for name, file in re.findall(r"^```toml\n# (\w+\.toml)\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        Path(name).write_text(file, encoding="utf-8")
    for language, code in blocks:
        if language == "python":
            exec(compile(code, page, "exec"), names)
        for line in code.replace("\\\n", "").splitlines() if language == "sh" else ():
            with pytest.raises(SystemExit) as end:
                main(shlex.split(line)[1:])
            assert end.value.code == 0, line
    if printed := PRINTED.search(text):
        assert capsys.readouterr().out == printed[1]


@pytest.mark.long
def test_the_loop_of_a_car_gives_what_estimate_does(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("car.toml").write_text(vehicle_text(brakes="true", rack_mass=12.0), encoding="utf-8")
    t, rack = steering()
    signals = [t, rack, SimulatedCar(mu=(0.6, 0.6)).force(rack)]
    write_columns(Path("g.csv"), dict(zip(("t", "rack", "F_rack"), signals, strict=True)))
    page = (ROOT / "docs" / "start" / "car.md").read_text(encoding="utf-8")
    (code,) = (code for language, code in BLOCK.findall(page) if language == "python")
    names = {"signals": zip(*map(np.ndarray.tolist, signals), strict=True)}

    exec(compile(code, "car.md", "exec"), names)
    with pytest.raises(SystemExit):
        main(["estimate", "--vehicle", "car.toml", "--observer", "ekf", "g.csv", "--out", "mu.csv"])
    row = table_of(Path("mu.csv"))

    assert names["now"].usable
    assert names["now"].mu_eff == pytest.approx(row["mu_eff"][-1], rel=1e-6)
    assert names["now"].mu_eff_std == pytest.approx(row["mu_eff_std"][-1], rel=1e-6)


@pytest.mark.parametrize(("missing", "kept"), [(slice(1, None, 2), True), (slice(-60, None), False)])
@pytest.mark.parametrize("page", ["README.md", "docs/start/controller.md"])
@pytest.mark.usefixtures("folder")
def test_a_loop_keeps_friction_between_torques_but_not_for_long(page, missing, kept) -> None:
    def gaps(*columns):
        *others, torque = map(np.array, columns)
        torque[: torque.size // 2 * 2][missing] = np.nan
        last = torque.size // 2 * 2
        return zip(*(column[:last] for column in (*others, torque)), strict=True)

    names = {"gaps": gaps}
    for _, code in [b for b in BLOCK.findall((ROOT / page).read_text("utf-8")) if b[0] == "python"][:2]:
        exec(code.replace(" in zip(", " in gaps("), names)

    assert not names["now"].usable
    assert (names["friction"] > 2 * names["LEAST"]) == kept


@pytest.mark.parametrize("page", ["README.md", "docs/start/controller.md"])
@pytest.mark.usefixtures("folder")
def test_a_loop_never_raises_friction_while_nothing_is_usable(page) -> None:
    ice = {"mu_eff": 0.053, "mu_eff_std": 0.005}
    each = [
        *[(0.0, 9.9, Status.ACQUIRING)] * 50, *[(0.053, 0.005, Status.USED)] * 50,
        *[(0.053, 0.005, Status.MISSING)] * 100, *[(0.053, 0.2, Status.RESET)] * 3,
    ]  # fmt: skip
    told = iter(each)
    acted: list[tuple[float, bool]] = []

    def loop(_):
        mu, std, status = next(told)
        given = {"mu": mu, "mu_std": std, "mu_eff": mu, "mu_eff_std": std}
        return Estimate(**given, M_z_predicted=0.0, informed=not status, status=status)

    def watched(*columns):
        for row in islice(zip(*columns, strict=True), len(each)):
            yield row
            acted.append((names["friction"], names["now"].usable))

    names: dict[str, Any] = {"watched": watched, "scripted": loop}
    for _, code in [b for b in BLOCK.findall((ROOT / page).read_text("utf-8")) if b[0] == "python"][:2]:
        code = re.sub(r"^loop = .*$", "loop = scripted", code, flags=re.MULTILINE)
        exec(code.replace(" in zip(", " in watched("), names)

    assert acted[-1][0] == pytest.approx(ice["mu_eff"] - 2 * ice["mu_eff_std"])
    before_and_now = pairwise([(0.05, False), *acted])
    assert all(usable or now <= before for (before, _), (now, usable) in before_and_now)


def test_figures_of_the_readme_stand_on_the_pages_that_it_names() -> None:
    results = (ROOT / "README.md").read_text(encoding="utf-8").partition("## Results")[2]
    rows = re.findall(r"^\| [^|]+ \| ([^|]+) \| (\[.*\)) \|$", results.partition("## ")[0], re.MULTILINE)
    assert len(rows) == 13
    for answer, pages in rows:
        pages = re.findall(r"\((.*?)\)", pages)
        text = "".join((ROOT / page).read_text(encoding="utf-8") for page in pages)
        figures = re.findall(r"(?<![\w.])\d[\d,./–]*(?<![,.])", answer)
        assert [figure for figure in figures if figure not in text] == []


def test_the_page_of_effects_has_the_whole_library() -> None:
    page = (ROOT / "docs" / "understand" / "effects.md").read_text(encoding="utf-8")
    table = page.partition("## One of your own")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \|.*\| ?([^|]*?) ?\|$", table, re.MULTILINE))

    assert rows == {
        name: ", ".join(f"`{p.name}` [{p.unit}]" for p in effect.parameters)
        for name, effect in KNOWN.items()
    }


@pytest.mark.parametrize("package", ["observers", "identification", "symbolic"])
def test_every_public_class_and_function_is_on_its_page_once(package: str) -> None:
    module = importlib.import_module(package)
    public = {name: getattr(module, name) for name in module.__all__}
    page = (ROOT / "docs" / "reference" / "api" / f"{package}.md").read_text(encoding="utf-8")
    listed = re.findall(rf"^\.\. auto\w+:: {package}\.(\w+)$", page, re.MULTILINE)
    # What identification passes on stands on the page of symbolic.
    own = {
        name
        for name, it in public.items()
        if (isinstance(it, type) or isfunction(it)) and it.__module__.partition(".")[0] == package
    }

    assert len(set(listed)) == len(listed)
    assert own <= set(listed) <= set(public)


@pytest.mark.long
@pytest.mark.parametrize("name", ["docs/understand/effects.md", "CONTRIBUTING.md"])
@pytest.mark.usefixtures("interpreted")
def test_the_effects_of_a_page_work(name: str) -> None:
    names: dict[str, Any] = {}
    for language, code in BLOCK.findall((ROOT / name).read_text(encoding="utf-8")):
        exec(code if language == "python" else "", names)
    kinds = [kind for kind in names.values() if isinstance(kind, type) and kind.__base__ is Effect]
    assert kinds
    for effect in (kind() for kind in kinds):
        model = Model(effects=(effect,), bristles=8)
        values = {f"{effect.name}.{p.name}": p.start for p in effect.parameters}
        psi = 0.2 * np.sin(0.1 * np.arange(200))
        signals = np.stack([psi, np.gradient(psi, 0.01), np.full(200, 400.0), np.full(200, 0.01)])
        theta = np.array(model.theta({"mu": 1.0, "k": 3e6, **values})).ravel()
        geometry = np.array([0.045, 0.009])
        by = simulate(model, signals, theta, geometry, np.eye(len(theta))).sensitivities
        assert np.abs(by[:, 2:]).max(axis=0).min() > 1e-3


def test_the_lower_end_of_each_direction_counts_in_a_table(tmp_path, monkeypatch, capsys) -> None:
    pytest.importorskip("pandas", reason="needs brushgrip[pandas]")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/start/cluster.md").read_text("utf-8")
    (line,) = re.findall(r'^python -c "(.*)"$', page, re.MULTILINE)
    names = ["mu_eff", "mu_eff_std", "mu_eff_positive", "mu_eff_std_positive", "mu_eff_negative"]
    names = ["recording", *names, "mu_eff_std_negative", "direction", "weaker", "since_usable"]
    header = ",".join(names)
    low_bands = ["0.5,0.05,,,,,,0,0", "1,0.02,1,0.02,0.5,0.05,positive,0.5,0"]
    others = [
        "0.5,0.15,,,,,,0,0", "0.5,0.05,,,,,,0.3,0", ",,,,,,,,", "1,0.02,1,0.02,,,positive,,0",
        # The weaker direction has a wider band than the one of mu_eff; the stronger may have the lower.
        "1,0.02,1,0.02,0.5,0.15,positive,0.5,0", "0.5,0.02,0.9,0.35,0.5,0.02,negative,0,0",
        "0.5,0.05,,,,,,0,0.3",  # Known, but not at the end.
    ]  # fmt: skip
    for rows, expected in ((low_bands, ""), (others, "a b c d e f g")):
        named = map(",".join, zip("abcdefg", rows, strict=False))
        Path("table.csv").write_text("\n".join([header, *named]))
        exec(line, {})
        assert capsys.readouterr().out == f"{expected}\n"


EVIDENCE = ROOT / "docs" / "evidence"


@pytest.mark.parametrize("name", ["left_out_search", "verdicts"])
def test_a_page_begins_as_its_script_says(name: str) -> None:
    page = (EVIDENCE / f"{name}.md").read_text(encoding="utf-8")

    assert page.startswith(importlib.import_module(name).OPENING)


@pytest.mark.parametrize(
    ("template_name", "page"), [("walk_through", "measured"), ("walk_through_search", "measured_search")]
)
def test_a_measured_page_is_its_template_with_figures(template_name: str, page: str) -> None:
    template = (ROOT / "examples" / f"{template_name}.in.md").read_text(encoding="utf-8")
    rest = (EVIDENCE / f"{page}.md").read_text(encoding="utf-8")
    *texts, last = re.split(r"\{\w+\}", template)
    for text in texts:
        _, found, rest = rest.partition(text)
        assert found == text
    assert rest.endswith(last)
