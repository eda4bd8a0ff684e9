"""What was identified from free vibrations, as a table on the screen."""

from typing import Any

from rich.console import Console
from rich.table import Table

from brushgrip.formatting import quantity
from identification.free_decay.results import FreeDecay
from identification.results import Estimate
from identification.thesis.fft_decrement import DecrementEstimate


def identified_document(identified: FreeDecay, decrement: DecrementEstimate) -> dict[str, Any]:
    """The content of the result's file: the identification, and the thesis's method beside it."""
    document = identified.to_dict()
    for recording, vibration in zip(document["recordings"], decrement.vibrations, strict=True):
        recording |= {"source_omega_n": vibration.omega_n, "source_zeta": vibration.zeta}
    document["recordings_units"] |= {"source_omega_n": "rad/s", "source_zeta": "1"}
    return document | {"source": decrement.to_dict()}


def print_identified(made: FreeDecay, decrement: DecrementEstimate) -> None:
    """Prints k and b_t by maximum likelihood and by the thesis's method, and what they rest on."""
    screen = Console(highlight=False, markup=False)
    screen.print(_values(made, decrement))
    forces = [
        f"{quantity(contact.force)} at a = {1000 * contact.a:g} mm"
        for contact in made.contacts
        if contact.force is not None
    ]
    if forces:
        screen.print(f"The ends of the patch slide as with μ F_N = {', '.join(forces)}.")
    for sentence in made.identifiability:
        screen.print(sentence)


def _values(made: FreeDecay, decrement: DecrementEstimate) -> Table:
    table = Table(title=f"From {len(made.vibrations)} free vibrations", title_justify="left")
    for heading in ("", "k", "b_t"):
        table.add_column(heading)
    values = (
        Estimate(value=parameter.value, std=parameter.std, unit=parameter.unit)
        for parameter in (made.k, made.b_t)
    )
    table.add_row("maximum likelihood", *map(quantity, values))
    for label, damping in (
        (
            "FFT and decrement, (5.8) with J_A",
            Estimate(value=decrement.b_t, std=None, unit=made.b_t.unit),
        ),
        (
            "FFT and decrement, (5.8) as printed",
            Estimate(value=decrement.b_t_printed, std=None, unit="1/s"),
        ),
    ):
        k = Estimate(value=decrement.k, std=None, unit=made.k.unit)
        table.add_row(label, quantity(k), quantity(damping))
    return table
