"""All classes of attack, in the order of the table; one more file is one more line here."""

from tests.attack import (
    command_lines,
    disks,
    faults,
    foreign,
    fuzzing,
    generated_c,
    long_runs,
    names,
    properties,
)
from tests.attack.attack_class import AttackClass

CLASSES: tuple[AttackClass, ...] = (
    *fuzzing.CLASSES,
    *properties.CLASSES,
    *long_runs.CLASSES,
    *generated_c.CLASSES,
    *command_lines.CLASSES,
    *names.CLASSES,
    *faults.CLASSES,
    *disks.CLASSES,
    *foreign.CLASSES,
)
