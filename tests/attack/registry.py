"""All classes of attack, in the order of the table; one more file is one more line here."""

from tests.attack import command_lines, faults, fuzzing, properties
from tests.attack.attack_class import AttackClass

CLASSES: tuple[AttackClass, ...] = (
    *fuzzing.CLASSES,
    *properties.CLASSES,
    *command_lines.CLASSES,
    *faults.CLASSES,
)
