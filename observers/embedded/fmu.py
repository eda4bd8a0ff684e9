"""An observer as an FMU: co-simulation by FMI 2.0 or 3.0 around the C that `generate` writes.

A communication step is one sample: it uses the inputs set before it, and the outputs after it are the
estimate.
"""

import platform
import subprocess
import tempfile
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from observers.embedded.codegen import INPUTS_OF, TORQUE_MEANING, source_texts
from observers.embedded.fmi_versions import VERSIONS, fmi_base_unit_xml, marked_unused
from observers.embedded.generated_file_overwriting import require_replaceable
from observers.embedded.jinja_templates import render
from observers.embedded.scalar_expansion import Tunable
from observers.embedded.scalar_type import SINGLE, Real
from observers.protocol import FunctionObserver
from symbolic import InvalidInputError, compiler

HOST = ("Linux", "x86_64")
COMPILER_FLAGS = (
    *("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno"),
    *("-fPIC", "-shared", "-fvisibility=hidden"),
)
"""Those of the CMake file, so that the FMU computes what the C computes, to the last bit."""
DATE = (1980, 1, 1, 0, 0, 0)
"""Time stamp of every file in the archive: the same observer gives the same bytes."""


@dataclass(frozen=True)
class FmiVariable:
    """A variable of the model description."""

    name: str
    reference: int  # Its value reference, as in `templates/fmu/state.c`.
    fmi2_type: str  # The type in FMI 2.0, see `TYPES`.
    unit: str | None  # Its unit; None for a flag.
    description: str


INPUTS = (
    FmiVariable("psi", 0, "Real", "rad", "yaw (steering) angle"),
    FmiVariable("psi_dot", 1, "Real", "rad/s", "yaw rate; a missing one is derived from psi"),
    *(FmiVariable(name, 2, "Real", "N.m", meaning) for name, meaning in TORQUE_MEANING.items()),
    FmiVariable(
        "F_N", 3, "Real", "N", "vertical load; missing below a twentieth of the first, and M_z with it"
    ),
)
"""All inputs."""
TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}
"""Types of FMI 2.0 and what they are in 3.0."""
OUTPUTS = (
    FmiVariable("mu", 4, "Real", "1", "coefficient of the model's own law; act on mu_eff"),
    FmiVariable("mu_std", 5, "Real", "1", "standard deviation of mu"),
    FmiVariable("M_z_predicted", 6, "Real", "N.m", "predicted aligning torque; NaN at first"),
    FmiVariable("informed", 7, "Boolean", None, "false while the estimate rests on the prior"),
    FmiVariable("usable", 14, "Boolean", None, "true where one may act on mu_eff: informed, no flag"),
    FmiVariable("mu_eff", 9, "Real", "1", "friction to act on, full slide over that of mu = 1"),
    FmiVariable("mu_eff_std", 10, "Real", "1", "standard deviation of mu_eff"),
    FmiVariable("M_slide", 11, "Real", "N.m", "torque of steady full slide, mean of both sides"),
    FmiVariable("nis", 12, "Real", "1", "normalised innovation squared; NaN if not measured"),
    FmiVariable(
        "status", 8, "Integer", None, "0 where the sample was used, else flags as in the C header"
    ),
    FmiVariable("weaker", 15, "Real", "1", "share of mu_eff that the weaker direction holds less"),
)


FIRST_PARAMETER = 16
"""Value reference of the first parameter."""


def generate_fmu(
    observer: FunctionObserver, folder: str | Path, real: Real = SINGLE, *, name: str = "brushgrip",
    version: int = 2, tunable: Tunable = "",
) -> Path:  # fmt: skip
    """Write an observer as `name`.fmu: co-simulation, sources, a library for 64-bit Linux.

    The version is that of FMI, 2 (2.0) or 3 (3.0); all other arguments are as for `generate`. Variables
    are double, whatever the type inside; parameters are tunable ones of the FMU.

    Returns:
        The file; its bytes follow from the arguments, the compiler and the versions in use.

    Raises:
        InvalidInputError: as for `generate`; another version, no C compiler, or no 64-bit Linux.
    """
    if version not in VERSIONS:
        raise InvalidInputError(f"version of FMI must be one of {list(VERSIONS)}, got {version!r}")
    texts = _archive_texts(observer, real, name, VERSIONS[version], tunable=tunable)
    sources = {
        Path(file).name: text
        for file, text in texts.items()
        if file.startswith("sources/") and file.endswith((".c", ".h"))
    }
    library = f"binaries/{VERSIONS[version]['library']}/{name}.so"
    files = {file: text.encode() for file, text in texts.items()}
    files[library] = _compile_shared_library(_compiler(), sources, name)
    file = Path(folder) / f"{name}.fmu"
    file.parent.mkdir(parents=True, exist_ok=True)
    require_replaceable([file])
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            entry = zipfile.ZipInfo(path, DATE)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return file


def is_supported_host() -> bool:
    """True on the one kind of machine for which the library is compiled."""
    return (platform.system(), platform.machine()) == HOST


def _compiler() -> str:
    """The compiler, or the reason why there can be no FMU."""
    if not is_supported_host():
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


def _archive_texts(
    observer: FunctionObserver, real: Real, name: str, version: Mapping[str, Any], *, tunable: Tunable
) -> dict[str, str]:
    """Every text of the archive, by its path."""
    texts, terms = source_texts(observer, real, name, tunable=tunable)
    parameters = texts[f"{name}.json"]
    terms = terms | {
        "guid": f"{{{uuid.uuid5(uuid.NAMESPACE_URL, texts[f'{name}.c'] + parameters)}}}",
        "inputs": [variable for variable in INPUTS if variable.name in INPUTS_OF[observer.channel]],
        "outputs": OUTPUTS,
        "types": TYPES,
        "first_parameter": FIRST_PARAMETER,
    }
    units = ["1", "s", *(v.unit for v in (*terms["inputs"], *OUTPUTS) if v.unit)]
    units += [parameter["fmi_unit"] for parameter in terms["parameters"]]
    terms["units"] = [(unit, fmi_base_unit_xml(unit)) for unit in dict.fromkeys(units)]
    fmi, of_version = version["fmi"], {**terms, **version, "unused": marked_unused}
    archive = {
        "modelDescription.xml": render(f"fmu/{version['description']}", terms),
        f"sources/{name}.c": texts[f"{name}.c"],
        f"sources/{name}.h": texts[f"{name}.h"],
        f"sources/{name}_fmu.c": render("fmu/fmu.c", of_version),
        f"sources/{fmi}.h": render(f"fmu/{fmi}.h", of_version),
        f"resources/{name}.json": parameters,
        "documentation/index.html": render("fmu/documentation.html", terms),
        "documentation/licenses/license.txt": render("fmu/license.txt", terms),
    }
    if version["build"]:
        archive["sources/buildDescription.xml"] = render("fmu/buildDescription.xml", terms)
    return archive


def _compile_shared_library(command: str, sources: Mapping[str, str], name: str) -> bytes:
    """The library of the sources, without any path or date of this machine."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8", newline="\n")
        units = [file for file in sources if file.endswith(".c")]
        arguments = [command, *COMPILER_FLAGS, *units, "-o", f"{name}.so", "-lm"]
        try:
            subprocess.run(arguments, cwd=folder, check=True, capture_output=True, timeout=300)
        except (OSError, subprocess.SubprocessError) as error:
            message = getattr(error, "stderr", None) or str(error).encode()
            first = message.decode(errors="replace").strip().splitlines()[0]
            raise InvalidInputError(f"{command} could not build the FMU: {first}") from None
        return (Path(folder) / f"{name}.so").read_bytes()
