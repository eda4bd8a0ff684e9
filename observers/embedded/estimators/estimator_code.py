"""An estimator on a patch as C."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca


@dataclass(frozen=True, kw_only=True)
class EstimatorCode:
    """An estimator on a patch as C; NAME stands for the name of the code.

    Attributes:
        template: defines `begin` and `advance`, which the public functions call.
        functions: Functions of scalars that it calls, beside those of every estimator.
        names: names of the elements of its vectors.
        terms: values of its placeholders.
        types: types of the state, C of the header.
        private: fields of the state, the patch among them.
        bytes: of these without the patch.
    """

    template: str
    functions: Sequence[ca.Function]
    names: Mapping[str, Sequence[str]]
    terms: Mapping[str, Any]
    types: str = ""
    private: str
    bytes: int
