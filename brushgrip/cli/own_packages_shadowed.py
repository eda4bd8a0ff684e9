"""The packages that brushgrip comes with, told from others of the same names."""

from importlib.util import find_spec
from pathlib import Path

BEGINNINGS = {
    "symbolic": '"""Ground floor: the physics',
    "observers": '"""Observers of the friction coefficient',
    "identification": '"""Identification: recordings',
}
"""How the package of each name begins that is ours."""


def foreign_packages() -> str:
    """One line on packages of another distribution that stand in the place of ours; empty for none.

    Nothing is imported: what stands there would run.
    """
    home = Path(__file__).resolve().parents[2]
    found = [(name, _origin(name)) for name in BEGINNINGS]
    wrong = [(name, origin) for name, origin in found if origin and not _is_ours(name, origin, home)]
    missing = [name for name, origin in found if origin is None]
    if not wrong and not missing:
        return ""
    places = [f"{name!r} in {origin.parent} is another distribution's" for name, origin in wrong]
    places += [f"{name!r} is missing" for name in missing]
    return (
        f"{', '.join(places)}; brushgrip needs its own packages of these names: give it an environment"
        " of its own (python -m venv), or uninstall the other distribution and install brushgrip anew"
    )


def _origin(name: str) -> Path | None:
    spec = find_spec(name)
    return Path(spec.origin).resolve() if spec and spec.origin else None


def _is_ours(name: str, origin: Path, home: Path) -> bool:
    if origin.parent != home / name:
        return False
    with origin.open(encoding="utf-8", errors="replace") as content:
        return content.readline().startswith(BEGINNINGS[name])
