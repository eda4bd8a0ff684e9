"""What was identified from free vibrations, as a table on the screen."""

from rich.console import Console
from rich.table import Table

from brushgrip.formatting import quantity
from identification.free_decay.results import FreeDecay
from identification.parameter_estimate import ParameterEstimate


def print_identified(made: FreeDecay) -> None:
    """Prints k and b_t by the programme and the source's way, and what they rest on."""
    screen = Console(highlight=False, markup=False)
    screen.print(_values(made))
    forces = [
        f"{quantity(contact.force)} at a = {1000 * contact.a:g} mm"
        for contact in made.contacts
        if contact.force is not None
    ]
    if forces:
        screen.print(f"The ends of the patch slide as with μ F_N = {', '.join(forces)}.")
    for sentence in made.identifiability:
        screen.print(sentence)


def _values(made: FreeDecay) -> Table:
    table = Table(title=f"From {len(made.vibrations)} free vibrations", title_justify="left")
    for heading in ("", "k", "b_t"):
        table.add_column(heading)
    values = (
        ParameterEstimate(value=parameter.value, std=parameter.std, unit=parameter.unit)
        for parameter in (made.k, made.b_t)
    )
    table.add_row("nonlinear programme", *map(quantity, values))
    source = made.source
    for label, damping in (
        (
            "source's way, (5.8) with J_A",
            ParameterEstimate(value=source.b_t, std=None, unit=made.b_t.unit),
        ),
        (
            "source's way, (5.8) as printed",
            ParameterEstimate(value=source.b_t_printed, std=None, unit="1/s"),
        ),
    ):
        k = ParameterEstimate(value=source.k, std=None, unit=made.k.unit)
        table.add_row(label, quantity(k), quantity(damping))
    return table
