"""Standard output and standard error on any terminal: other encodings, a full disk, a closed pipe."""

import codecs
import errno
import os
import sys
import unicodedata

_SPELT = {
    "μ": "mu",
    "ψ": "psi",
    "ϑ": "theta",
    "±": "+/-",
    "–": "-",
    "−": "-",
    "→": "->",
    "·": "*",
    "…": "...",
    "“": '"',
    "”": '"',
    "∞": "inf",
    "²": "^2",
    "³": "^3",
    "⁻": "^-",
}
"""Signs that we write, where the terminal's encoding lacks them."""


def spell_what_is_lacking() -> None:
    """Have standard output and error spell the signs that their encoding lacks, instead of failing."""
    codecs.register_error("brushgrip", _spelt)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None and not (stream.encoding or "").lower().startswith("utf"):
            reconfigure(errors="brushgrip")


def _spelt(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    spelt = "".join(map(_spelling, error.object[error.start : error.end]))
    return spelt.replace("^-^", "^-"), error.end


def _spelling(sign: str) -> str:
    plain = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode("ascii")
    return _SPELT.get(sign) or plain or sign.encode("unicode_escape").decode("ascii")


def fault_of_output() -> str | None:
    """Reason why standard output cannot be written, and is given up; None for none."""
    try:
        sys.stdout.flush()
    except OSError as error:
        # Else the interpreter tries once more at its end, and says so in a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        # On Windows a closed pipe is an invalid argument.
        closed_there = sys.platform == "win32" and error.errno == errno.EINVAL
        is_closed = isinstance(error, BrokenPipeError) or closed_there
        return "" if is_closed else str(error.strerror or error)
    return None
