"""Guards on the shape of the project: who may import whom, how large a piece may grow."""

import ast
import importlib
import importlib.metadata
import re
import shutil
import subprocess
import sysconfig
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest

PACKAGES = ("symbolic", "observers", "identification", "brushgrip")
FOLDERS = (*PACKAGES, "reference_rig", "examples", "benchmarks")
Node = TypeVar("Node", bound=ast.AST)
MAX_FILE_LINES = 300
MAX_FUNCTION_LINES = 60
MACHINE_PATH = re.compile(r"(?<![\w.~)}])/(?:work|root|tmp|home)/")


def source_files(root: Path, folders: Iterable[str] = PACKAGES) -> Iterator[Path]:
    for folder in folders:
        yield from sorted((root / folder).rglob("*.py"))


def nodes_of(
    kind: type[Node] | tuple[type[Node], ...], root: Path, folders: Iterable[str] = PACKAGES
) -> Iterator[tuple[Path, Node]]:
    for path in source_files(root, folders):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, kind):
                yield path, node


@pytest.mark.parametrize("package", PACKAGES)
def test_package_comes_from_this_checkout(package: str, repository_root: Path) -> None:
    # Other distributions on PyPI install packages named `symbolic` and `observers`.
    origin = importlib.import_module(package).__file__

    assert origin is not None, f"{package} has no __init__.py"
    assert Path(origin).resolve().is_relative_to(repository_root / package)


def test_no_other_distribution_installs_our_packages() -> None:
    # pytest puts the checkout first; the installed command does not, and would import theirs.
    installed = importlib.metadata.packages_distributions()

    assert {p: installed.get(p, []) for p in PACKAGES if set(installed.get(p, [])) - {"brushgrip"}} == {}


@pytest.mark.parametrize("package", [*PACKAGES, "reference_rig"])
def test_init_only_re_exports(package: str, repository_root: Path) -> None:
    for init in sorted((repository_root / package).rglob("__init__.py")):
        docstring, *rest = ast.parse(init.read_text("utf-8")).body
        definitions = [node.lineno for node in rest if not _is_re_export(node)]

        assert isinstance(docstring, ast.Expr), f"{init}: begins with its docstring"
        assert not definitions, f"{init}: lines {definitions} do more than re-export"


@pytest.mark.parametrize("package", PACKAGES)
def test_public_names_resolve(package: str) -> None:
    module = importlib.import_module(package)

    assert dir(module) == sorted(module.__all__)
    assert len(module.__all__) == len(set(module.__all__))
    assert [name for name in module.__all__ if not hasattr(module, name)] == []


def test_files_hold_one_idea(repository_root: Path) -> None:
    lengths = {path: len(path.read_text("utf-8").splitlines()) for path in source_files(repository_root)}

    assert {path: n for path, n in lengths.items() if n > MAX_FILE_LINES} == {}


def test_functions_fit_on_a_page(repository_root: Path) -> None:
    lengths = {
        f"{path}:{node.lineno}": (node.end_lineno or node.lineno) - node.lineno + 1
        for path, node in nodes_of((ast.FunctionDef, ast.AsyncFunctionDef), repository_root)
    }

    assert {where: n for where, n in lengths.items() if n > MAX_FUNCTION_LINES} == {}


def test_no_class_name_stands_twice(repository_root: Path) -> None:
    names = Counter(node.name for _, node in nodes_of(ast.ClassDef, repository_root, FOLDERS))

    assert {name for name, count in names.items() if count > 1} == set()


def test_the_rig_is_used_through_its_door(repository_root: Path) -> None:
    deep = [
        f"{path.relative_to(repository_root)}:{node.lineno}"
        for path, node in nodes_of(ast.ImportFrom, repository_root, ("examples", "benchmarks", "tests"))
        if (node.module or "").startswith("reference_rig.")
    ]

    assert deep == []


def test_import_contracts_hold(repository_root: Path) -> None:
    command = Path(sysconfig.get_path("scripts")) / "lint-imports"
    told = {"capture_output": True, "text": True, "check": False}
    result = subprocess.run([command, "--no-cache"], cwd=repository_root, **told)

    assert result.returncode == 0, result.stdout + result.stderr


def test_no_path_of_one_machine(repository_root: Path) -> None:
    offenders = [
        f"{path.relative_to(repository_root)}:{number} {line.strip()}"
        for path in _project_files(repository_root)
        for number, line in enumerate(_text_lines(path), start=1)
        if MACHINE_PATH.search(line)
    ]

    assert offenders == []


def _is_re_export(node: ast.stmt) -> bool:
    if isinstance(node, ast.Assign):
        assigned = [ast.unparse(target) for target in node.targets]
        # `dir` of a package lists what is public alone.
        return assigned == ["__all__"] or ast.unparse(node) == "__dir__ = __all__.copy"
    if isinstance(node, ast.If):  # What is imported late, as a type checker reads it.
        return ast.unparse(node.test) == "TYPE_CHECKING" and all(map(_is_re_export, node.body))
    return isinstance(node, ast.Import | ast.ImportFrom)


def _project_files(root: Path) -> list[Path]:
    """Tracked files, and new ones that will be: a fault should show before it is committed."""
    if shutil.which("git") is None or not (root / ".git").exists():
        pytest.skip("git lists the project's files: not a git checkout, or no git")
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listing = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout
    return [root / name for name in listing.split("\0") if name and (root / name).is_file()]


def _text_lines(path: Path) -> list[str]:
    content = path.read_bytes()
    return [] if b"\0" in content else content.decode("utf-8", errors="replace").splitlines()


def test_links_of_the_pages_lead_somewhere(repository_root: Path) -> None:
    pages = [p for p in _project_files(repository_root) if p.suffix == ".md" and ".in." not in p.name]
    broken = [
        f"{page.name}: {link}"
        for page in pages
        for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text("utf-8"))
        if "://" not in link and "gallery/" not in link and not (page.parent / link).exists()
    ]
    unfilled = [
        f"{page.name}: {word}"
        for page in pages
        for word in re.findall(r"^[A-Z]+_[A-Z]+$", page.read_text("utf-8"), flags=re.MULTILINE)
    ]

    assert len(pages) > 4
    assert broken + unfilled == []


CITATION = re.compile(r"\[((?:[a-z]+ )?[A-ZÀ-Ž][\w'-]+(?: [A-ZÀ-Ž][\w'-]+)*[ \n]+(?:18|19|20)\d\d)\]")


def test_every_citation_stands_among_the_references(repository_root: Path) -> None:
    references = (repository_root / "docs" / "reference" / "references.md").read_text("utf-8")
    listed = re.findall(r"^\| \[([^]]+)\] \|", references, flags=re.MULTILINE)
    unknown = [
        f"{path.relative_to(repository_root)}: {key}"
        for path in _project_files(repository_root)
        if path.suffix in (".py", ".md", ".c", ".h", ".toml", ".html")
        for key in CITATION.findall(path.read_text("utf-8"))
        if " ".join(key.split()) not in listed
    ]

    assert len(listed) == len(set(listed)) > 20
    assert all(CITATION.fullmatch(f"[{key}]") for key in listed)
    assert unknown == []
