"""Identify k and b_t from a wheel that is struck and swings: the programme beside the thesis.

    python examples/free_decay.py [PICTURE.png]

The recordings come from the independent rig: seven contact lengths, two impacts each, a few mrad on a
14-bit encoder, 1 kHz. In [Györök 2022] all bristles stick; but friction holds nothing at the
patch's ends, which slide in every swing, soften the spring and take energy. The programme counts that
in, and so finds the friction force as well.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from brushgrip.pictures import draw_free_decay
from identification import identify_free_decay
from reference_rig.impact import B_T, TYRE, load_at, make_impacts
from rig_recordings import as_decay


def main() -> None:
    """Print k and b_t by every way beside what was planted."""
    decays = [as_decay(recording) for recording in make_impacts(11, impacts=2)]
    result, sticking = identify_free_decay(decays), identify_free_decay(decays, sliding=False)
    print(f"planted: k = {TYRE.k:.4g} N/m^2, b_t = {B_T} N m s/rad, mu = {TYRE.mu}")
    for way, k, b_t in (
        ("programme, ends slide", result.k.value, result.b_t.value),
        ("programme, all sticks", sticking.k.value, sticking.b_t.value),
        ("thesis's way", result.source.k, result.source.b_t),
    ):
        errors = f"off by {100 * (k / TYRE.k - 1):+.3f} % and {100 * (b_t / B_T - 1):+.3f} %"
        print(f"{way:22} k = {k:.5g}, b_t = {b_t:.4f}: {errors}")
    print(f"standard deviations: k ± {result.k.std:.2g} N/m^2, b_t ± {result.b_t.std:.2g} N m s/rad")
    print(f"(5.8) as printed, without J_A: {result.source.b_t_printed:.3f}, which is b_t/J_A in 1/s")
    forces = [(contact.force, load_at(contact.a)) for contact in result.contacts if contact.force]
    mu = np.array([(force.value / load, (force.std or 0.0) / load) for force, load in forces])
    mean, spread = mu.mean(axis=0)
    print(f"friction from {len(mu)} contacts: mu = {mean:.3f}, each ± {spread:.3f}")
    for sentence in result.identifiability:
        print(sentence)
    if sys.argv[1:]:
        draw_free_decay(Path(sys.argv[1]), result)


if __name__ == "__main__":
    main()
