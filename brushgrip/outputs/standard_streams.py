"""Standard output and standard error on any terminal: other encodings, a full disk, a closed pipe."""

import codecs
import errno
import logging
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


_OF_FILES = ("identification.reading.readers", "identification.reading.recordings")
"""Loggers whose remarks are a file's name and a text."""


class _FirstFile(logging.Filter):
    """Lets a remark on files pass for the first of those that it is true of."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: set[object] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the text, all but the file's name, is new."""
        text = (record.msg, tuple(record.args or ())[1:])
        known = text in self.texts
        self.texts.add(text)
        return not known


_FIRST_FILE = _FirstFile()


def remark_once() -> None:
    """Have each remark on files said once in this process."""
    for name in _OF_FILES:
        logging.getLogger(name).addFilter(_FIRST_FILE)


def forget_remarks() -> None:
    """Have remarks on files said each time again."""
    _FIRST_FILE.texts.clear()
    for name in _OF_FILES:
        logging.getLogger(name).removeFilter(_FIRST_FILE)


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
