"""Names of one file of C, so that several files can be compiled as one translation unit.

What a file defines for itself (static functions and tables, types, macros, constants of enumerations)
gets the prefix of its observer. Names are found where they are defined at the beginning of a line, and
replaced where they stand as a word: not in comments and strings, not behind a dot or an arrow.
"""

import re

from observers.embedded.scalar_type import tokens

_STATIC = re.compile(r"^static [\w \t*]*?\b(\w+)\s*(?:\(|\[|=|;)", re.MULTILINE)
_MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)
_TYPE = re.compile(r"^} (\w+);", re.MULTILINE)
_ENUM = re.compile(r"^enum \{(.*?)\};", re.MULTILINE | re.DOTALL)
_CONSTANT = re.compile(r"(?:^|,)\s*(\w+)")


def defined_names(text: str) -> frozenset[str]:
    """Names that a file of C defines for itself."""
    code = "".join(" " if kind == "comment" else token for kind, token in tokens(text))
    constants = (_CONSTANT.findall(inside) for inside in _ENUM.findall(code))
    found = [_STATIC.findall(code), _MACRO.findall(code), _TYPE.findall(code), *constants]
    return frozenset(name for names in found for name in names)


def with_prefix(text: str, name: str) -> str:
    """A file of C whose own names begin with `name`; names that do so already stay."""
    taken = (f"{name}_", f"{name.upper()}_")
    own = {n for n in defined_names(text) if not n.startswith(taken)}

    renamed, before = [], ""
    for kind, token in tokens(text):
        is_own = kind == "name" and token in own and not before.endswith((".", "->"))
        renamed.append(f"{taken[token.isupper()]}{token}" if is_own else token)
        if kind != "comment":
            before = (before + token.strip())[-2:]
    return "".join(renamed)
