"""Files and folders of results that are written whole or not at all."""

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from symbolic import InvalidInputError
from symbolic.compilation.self_cleaning_folder import temporary_folder


@contextmanager
def staged_file(final: str | Path) -> Iterator[Path]:
    """Yields a path to write to; on success it takes the place of the final file.

    Missing folders are made, on success. Enter before a long calculation, and an unwritable place
    shows at once. A pipe or a device is written to directly.
    """
    final = Path(final)
    with as_input_error(final):
        if final.is_dir():
            raise InvalidInputError(f"{final}: is a folder, expected the name of a file")
        direct = final.exists() and not final.is_file()
    if direct:
        yield final
        return
    with ExitStack() as stack:
        with as_input_error(final):
            target = final.resolve()
            stage = stack.enter_context(temporary_folder(_existing_folder(target))) / target.name
            stage.touch()
        yield stage
        with as_input_error(final):
            target.parent.mkdir(parents=True, exist_ok=True)
            stage.replace(target)


@contextmanager
def staged_files(finals: Sequence[Path]) -> Iterator[list[Path]]:
    """Paths to write to, which take the places of all final files in the end; see `staged_file`."""
    with ExitStack() as stack:
        yield [stack.enter_context(staged_file(final)) for final in finals]


@contextmanager
def staged_directory(final: str | Path) -> Iterator[Path]:
    """Yields an empty folder; on success what it holds is moved into the final folder.

    The final folder and missing folders above it are made, on success; other files in it stay.
    """
    final = Path(final)
    with ExitStack() as stack:
        with as_input_error(final):
            target = final.resolve()
            if target.exists() and not target.is_dir():
                raise InvalidInputError(f"{final}: is not a folder")
            stage = stack.enter_context(temporary_folder(_existing_folder(target / "stage"))) / "stage"
            stage.mkdir()
        yield stage
        with as_input_error(final):
            _move_into(stage, target)


def write_utf8(path: Path, text: str) -> None:
    """The text as UTF-8 with the same ends of lines everywhere."""
    path.write_text(text, encoding="utf-8", newline="\n")


def table_path(out: Path, label: str, count: int) -> Path:
    """The file of one of several recordings: OUT_<label>, OUT itself for a single one."""
    return out if count == 1 else out.with_stem(f"{out.stem}_{label}")


def check_png_name(picture: Path) -> None:
    """Refuses a picture that is no PNG."""
    if picture.suffix.lower() != ".png":
        raise InvalidInputError(f"{picture}: the picture needs a name that ends in .png")


def table_and_picture(out: Path | None) -> list[Path]:
    """A table or result, and its picture of the same name with .png; nothing where there is no table.

    Raises:
        InvalidInputError: the name ends in .png itself.
    """
    if out and out.suffix.lower() == ".png":
        raise InvalidInputError(
            f"{out}: the result needs a name such as .csv or .json; .png is its picture"
        )
    return [out, out.with_suffix(".png")] if out else []


def is_same_file(one: Path, other: Path) -> bool:
    """Whether what is written to one path would replace the file at the other."""
    return not file_identity_keys(one).isdisjoint(file_identity_keys(other))


def file_identity_keys(path: Path) -> set[object]:
    """Identity of a file, also behind folders that are not there yet; two that share a key are one."""
    # Takes loops of links, as resolve does not.
    real = os.path.realpath(path)
    try:
        found = Path(real).stat()
    except (OSError, ValueError):  # It is not there, or its name is none.
        return {real}
    return {real, (found.st_dev, found.st_ino)}


def _existing_folder(target: Path) -> Path:
    """The nearest folder that exists: renaming from there is atomic."""
    return next(parent for parent in target.parents if parent.exists())


def _move_into(stage: Path, target: Path) -> None:
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        # Another run may have made it by now.
        with suppress(OSError):
            stage.rename(target)
            return
    entries = [path.relative_to(stage) for path in sorted(stage.rglob("*"))]
    for entry in entries:
        new, old = stage / entry, target / entry
        if old.exists() and old.is_dir() != new.is_dir():
            raise InvalidInputError(f"{old}: is in the way; remove it, or name another folder")
    for entry in entries:
        if (stage / entry).is_dir():
            (target / entry).mkdir(exist_ok=True)
        else:
            (stage / entry).replace(target / entry)


@contextmanager
def as_input_error(path: Path) -> Iterator[None]:
    """Says in one line why a path cannot be written."""
    try:
        yield
    except (OSError, RuntimeError) as error:  # The latter is what Python 3.11 says of a loop of links.
        reason = getattr(error, "strerror", None) or error
        raise InvalidInputError(f"{path}: cannot be written: {reason}") from None
