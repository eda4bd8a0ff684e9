"""Values of a parameter on grounds: the mean that stands for a ground which is not among them."""

import math
from collections.abc import Collection, Mapping


def mean_over_grounds(grounds: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """For each parameter the mean of its values on these grounds, see `mean_value`."""
    names = dict.fromkeys(name for values in grounds.values() for name in values)
    return {name: mean_value([v[name] for v in grounds.values() if name in v]) for name in names}


def mean_value(values: Collection[float]) -> float:
    """The geometric mean of values of one sign, the arithmetic mean where there are two or a zero."""
    least, most = min(values), max(values)
    if least == most:
        return least
    if least * most > 0:
        logarithms = [math.log(abs(value)) for value in values]
        return math.copysign(math.exp(math.fsum(logarithms) / len(values)), most)
    return math.fsum(values) / len(values)
