"""The packages that brushgrip comes with, told from others of the same names."""

from importlib.util import find_spec
from pathlib import Path

BEGINNINGS = {
    "symbolic": '"""Ground floor: the physics',
    "observers": '"""Observers of the friction coefficient',
    "identification": '"""Identification: recordings',
}
"""How the package of each name begins that is ours."""


def shadowed_packages_message() -> str:
    """One line on packages of another distribution that stand in the place of ours; empty for none.

    Nothing is imported: what stands there would run.
    """
    home = Path(__file__).resolve().parents[2]
    places, missing = [], []
    for name in BEGINNINGS:
        spec = find_spec(name)
        if not spec or not spec.origin:
            missing.append(f"{name!r} is missing")
        elif not _is_ours(name, origin := Path(spec.origin).resolve(), home):
            places.append(f"{name!r} in {origin.parent} is another distribution's")
    if not (places := places + missing):
        return ""
    return (
        f"{', '.join(places)}; brushgrip needs its own packages of these names: give it an environment"
        " of its own (python -m venv), or uninstall the other distribution and install brushgrip anew"
    )


def _is_ours(name: str, origin: Path, home: Path) -> bool:
    if origin.parent != home / name:
        return False
    with origin.open(encoding="utf-8", errors="replace") as content:
        return content.readline().startswith(BEGINNINGS[name])
