"""The floating-point type of a target."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Real:
    """How numbers are held on the target.

    Attributes:
        c_type: the type in C.
        suffix: what a literal of this type ends in, and the names of its functions in math.h.
        dtype: the same in NumPy.
        digits: significant digits that tell any two numbers apart.
        greatest: largest finite number.
    """

    c_type: str
    suffix: str
    dtype: type[np.floating]
    digits: int
    greatest: float

    def literal(self, value: float) -> str:
        """A number as C writes it in this type; NAN and INFINITY from math.h."""
        rounded = float(self.dtype(value))
        if np.isnan(rounded):
            return f"({self.c_type})NAN"
        if np.isinf(rounded):
            return f"({self.c_type}){'-' * (rounded < 0)}INFINITY"
        return f"{rounded:.{self.digits - 1}e}{self.suffix}"

    @property
    def size(self) -> int:
        """Bytes of a number."""
        return np.dtype(self.dtype).itemsize

    def round(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Numbers as the target holds them."""
        return np.asarray(values).astype(self.dtype).astype(float)


SINGLE = Real(
    c_type="float", suffix="f", dtype=np.float32, digits=9, greatest=float(np.finfo(np.float32).max)
)
"""IEEE single precision, what the floating-point unit of a Cortex-M4F computes."""
DOUBLE = Real(
    c_type="double", suffix="", dtype=np.float64, digits=17, greatest=float(np.finfo(np.float64).max)
)
"""IEEE double precision, the same as in Python."""
