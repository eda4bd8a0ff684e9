"""Pages that scripts write hold the text of their script or template."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EVIDENCE = ROOT / "docs" / "evidence"


@pytest.mark.parametrize("name", ["left_out_search", "verdicts"])
def test_a_page_begins_as_its_script_says(name: str) -> None:
    page = (EVIDENCE / f"{name}.md").read_text(encoding="utf-8")

    assert page.startswith(importlib.import_module(name).OPENING)


@pytest.mark.parametrize(
    ("template_name", "page"),
    [("walk_through", "measured"), ("walk_through_search", "measured_search")],
)
def test_a_measured_page_is_its_template_with_figures(template_name: str, page: str) -> None:
    template = (ROOT / "examples" / f"{template_name}.in.md").read_text(encoding="utf-8")
    rest = (EVIDENCE / f"{page}.md").read_text(encoding="utf-8")
    *texts, last = re.split(r"\{\w+\}", template)
    for text in texts:
        _, found, rest = rest.partition(text)
        assert found == text
    assert rest.endswith(last)
