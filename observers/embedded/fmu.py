"""An observer as an FMU: FMI 2.0 co-simulation around the C that `generate` writes.

A communication step is one sample: `fmi2DoStep` takes the inputs that stand at its beginning, and what
it says of them stands at its end. The archive holds the sources, the model description, the parameters
and the library for 64-bit Linux.
"""

import json
import platform
import subprocess
import tempfile
import uuid
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from observers.embedded.codegen import checked, terms_of, texts_of
from observers.embedded.fmi_variables import variables_of
from observers.embedded.scalar_type import SINGLE, Real
from observers.embedded.templating import filled
from observers.protocol import FunctionObserver
from symbolic import InvalidInputError
from symbolic.compiled import compiler

HOST = ("Linux", "x86_64")
FLAGS = (
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
)
"""Those of the CMake file, so that the FMU says what the C says, to the last bit."""
DATE = (1980, 1, 1, 0, 0, 0)
"""Of every file in the archive: the same observer makes the same bytes."""


def generate_fmu(
    observer: FunctionObserver, folder: str | Path, real: Real = SINGLE, *, name: str = "brushgrip"
) -> Path:
    """Write an observer as `name`.fmu: FMI 2.0 co-simulation, sources, a library for 64-bit Linux.

    Args:
        observer: an `Ekf`, an `Mhe`, or any other `FunctionObserver`.
        folder: where to; made if it is not there.
        real: the type of every number inside; the variables are double in any case.
        name: of the model, and of the file.

    Returns:
        The file; its bytes follow from the arguments, the compiler and the versions in use.

    Raises:
        InvalidInputError: as for `generate`; there is no C compiler, or this is no 64-bit Linux.
    """
    made = checked(observer, name)
    command = _compiler()
    sources, description, parameters = _texts(made, real, name)
    files = {
        "modelDescription.xml": description.encode(),
        **{f"sources/{file}": text.encode() for file, text in sources.items()},
        f"resources/{name}.json": parameters.encode(),
        f"binaries/linux64/{name}.so": _library(command, sources, name),
    }
    file = Path(folder) / f"{name}.fmu"
    file.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            entry = zipfile.ZipInfo(path, DATE)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return file


def is_host() -> bool:
    """True on the one kind of machine that is built for."""
    return (platform.system(), platform.machine()) == HOST


def _compiler() -> str:
    """The compiler, or why there can be no FMU."""
    if not is_host():
        raise InvalidInputError(
            f"an FMU is built on {' '.join(HOST)}, this is {platform.system()} {platform.machine()};"
            " write C instead, --target c"
        )
    if (command := compiler()) is None:
        raise InvalidInputError(
            "an FMU needs a C compiler and none was found; install one or name it in CC,"
            " and leave BRUSHGRIP_INTERPRET unset"
        )
    return command


def _texts(observer: FunctionObserver, real: Real, name: str) -> tuple[dict[str, str], str, str]:
    """The sources by file, the model description, the parameters."""
    texts, terms = texts_of(observer, real, name), terms_of(observer, real, name)
    parameters = texts[f"{name}.json"]
    variables = variables_of(terms["torque"])
    terms |= {
        "version": json.loads(parameters)["version"],
        "guid": f"{{{uuid.uuid5(uuid.NAMESPACE_URL, texts[f'{name}.c'] + parameters)}}}",
        "variables": "\n".join(variable.element for variable in variables),
        # Nothing follows from an input at once: outputs change with a step alone.
        "unknowns": "\n".join(
            f'      <Unknown index="{number}" dependencies=""/>'
            for number, variable in enumerate(variables, start=1)
            if not variable.given
        ),
    }
    sources = {file: texts[file] for file in (f"{name}.c", f"{name}.h")}
    sources |= {f"{name}_fmu.c": filled("fmu.c", terms), "fmi2.h": filled("fmi2.h", {})}
    plain = {part: escape(text) for part, text in terms.items() if part not in {"variables", "unknowns"}}
    return sources, filled("modelDescription.xml", {**terms, **plain}), parameters


def _library(command: str, sources: Mapping[str, str], name: str) -> bytes:
    """The sources compiled and linked; no path and no date of this machine gets in."""
    with tempfile.TemporaryDirectory() as scratch:
        for file, text in sources.items():
            (Path(scratch) / file).write_text(text, encoding="utf-8", newline="\n")
        units = [file for file in sources if file.endswith(".c")]
        arguments = [command, *FLAGS, *units, "-o", f"{name}.so", "-lm"]
        try:
            subprocess.run(arguments, cwd=scratch, check=True, capture_output=True, timeout=300)
        except (OSError, subprocess.SubprocessError) as error:
            said = getattr(error, "stderr", None) or str(error).encode()
            first = said.decode(errors="replace").strip().splitlines()[0]
            raise InvalidInputError(f"{command} could not build the FMU: {first}") from None
        return (Path(scratch) / f"{name}.so").read_bytes()
