"""Standard output and standard error on any terminal: other encodings, a full disk, a closed pipe."""

import codecs
import errno
import logging
import os
import sys
import unicodedata
from contextvars import ContextVar

_SPELT = {
    "μ": "mu", "ψ": "psi", "ϑ": "theta", "∞": "inf", "²": "^2", "³": "^3", "⁻": "^-",
    "±": "+/-", "–": "-", "−": "-", "→": "->", "·": "*", "…": "...", "“": '"', "”": '"',
}  # fmt: skip
"""Signs that we write, where the terminal's encoding lacks them."""


REMARKS: ContextVar[set[object] | None] = ContextVar("REMARKS", default=None)
"""Remarks on files that a command has made; None where no command runs."""


def is_first_remark(record: logging.LogRecord) -> bool:
    """Whether a remark on a file, all but the file's name, is the command's first such."""
    made, text = REMARKS.get(), (record.msg, *tuple(record.args or ())[1:])
    if made is None or text in made:
        return made is None
    made.add(text)
    return True


for _name in ("readers", "recordings"):
    logging.getLogger(f"identification.reading.{_name}").addFilter(is_first_remark)


def replace_unencodable_characters() -> None:
    """Have standard output and error spell the signs that their encoding lacks, instead of failing."""
    codecs.register_error("brushgrip", _replace_unencodable)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None and not (stream.encoding or "").lower().startswith("utf"):
            reconfigure(errors="brushgrip")


def _replace_unencodable(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    spelt = ""
    for sign in error.object[error.start : error.end]:
        plain = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode("ascii")
        spelt += _SPELT.get(sign) or plain or sign.encode("unicode_escape").decode("ascii")
    return spelt.replace("^-^", "^-"), error.end


def stdout_fault() -> str | None:
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
