"""k and b_t from free vibration
=============================

Identify k and b_t from a wheel that is struck and swings: by likelihood, and by FFT and decrement.

.. code-block:: sh

    python examples/free_decay.py [PICTURE.png]

The recordings come from the independent rig: seven contact lengths, two impacts each, a few mrad on a
14-bit encoder, 1 kHz. In [Györök 2022] all bristles stick; but friction holds nothing at the patch's
ends, which slide in every swing, soften the spring and dissipate energy. The likelihood includes
that, and so the friction force is found as well.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from brushgrip.pictures.free_decay_fit_quality import draw_free_decay
from identification import identify_free_decay
from identification.thesis import estimate_by_decrement
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from reference_rig import load_at, make_impacts
from rig_recordings import as_decay


def main() -> None:
    """Print k and b_t by every way beside what was planted."""
    decays = [as_decay(recording) for recording in make_impacts(11, impacts=2)]
    result, sticking = identify_free_decay(decays), identify_free_decay(decays, sliding=False)
    decrement = estimate_by_decrement(decays)
    print(f"planted: k = {TYRE.k:.4g} N/m^2, b_t = {B_T} N m s/rad, mu = {TYRE.mu}")
    for way, k, b_t in (
        ("likelihood, ends slide", result.k.value, result.b_t.value),
        ("likelihood, all sticks", sticking.k.value, sticking.b_t.value),
        ("FFT and decrement", decrement.k, decrement.b_t),
    ):
        errors = f"off by {100 * (k / TYRE.k - 1):+.3f} % and {100 * (b_t / B_T - 1):+.3f} %"
        print(f"{way:22} k = {k:.5g}, b_t = {b_t:.4f}: {errors}")
    print(f"standard deviations: k ± {result.k.std:.2g} N/m^2, b_t ± {result.b_t.std:.2g} N m s/rad")
    print(f"(5.8) as printed, without J_A: {decrement.b_t_printed:.3f}, which is b_t/J_A in 1/s")
    forces = [(contact.force, load_at(contact.a)) for contact in result.contacts if contact.force]
    mu = np.array([(force.value / load, (force.std or 0.0) / load) for force, load in forces])
    mean, spread = mu.mean(axis=0)
    print(f"friction from {len(mu)} contacts: mu = {mean:.3f}, each ± {spread:.3f}")
    for sentence in result.identifiability:
        print(sentence)
    if sys.argv[1:]:
        draw_free_decay(Path(sys.argv[1]), result, decrement)


if __name__ == "__main__":
    main()
