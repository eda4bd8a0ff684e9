"""Arrays of real numbers, as annotations have them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
