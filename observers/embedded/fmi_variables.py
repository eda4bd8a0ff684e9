"""What an FMU of an observer takes and says, as variables of its model description."""

from dataclasses import dataclass
from xml.sax.saxutils import quoteattr


@dataclass(frozen=True, kw_only=True)
class Variable:
    """A variable of the model description.

    Attributes:
        name: its name.
        reference: its value reference, as in `templates/fmu.c`.
        kind: element that says its type, with the unit.
        said: what it is.
    """

    name: str
    reference: int
    kind: str
    said: str

    @property
    def given(self) -> bool:
        """True for an input, False for an output."""
        return self.reference < FIRST_OUTPUT

    @property
    def element(self) -> str:
        """As modelDescription.xml has it; an input that nobody sets is a sensor that is not there."""
        role = 'input"' if self.given else 'output" initial="calculated"'
        start = ' start="NaN"' if self.given else ""
        return (
            f'    <ScalarVariable name="{self.name}" valueReference="{self.reference}"'
            f' variability="discrete" causality="{role}\n        description={quoteattr(self.said)}>'
            f"<{self.kind}{start}/></ScalarVariable>"
        )


FIRST_OUTPUT = 4
PSI = Variable(name="psi", reference=0, kind='Real unit="rad"', said="yaw (steering) angle")
RATE = Variable(
    name="psi_dot",
    reference=1,
    kind='Real unit="rad/s"',
    said="yaw rate; where there is none it is taken from the past of psi",
)
TORQUES = {
    "M_z": "aligning torque, moment of the ground on the wheel",
    "M": "steering torque, of the hand or motor on the wheel",
}
LOAD = Variable(
    name="F_N",
    reference=3,
    kind='Real unit="N"',
    said="vertical load; the last one holds where there is none greater than 0",
)
OUTPUTS = (
    Variable(name="mu", reference=4, kind='Real unit="1"', said="friction coefficient"),
    Variable(name="mu_std", reference=5, kind='Real unit="1"', said="standard deviation of mu"),
    Variable(
        name="M_z_predicted",
        reference=6,
        kind='Real unit="N.m"',
        said="aligning torque of the model before its measurement was seen; NaN at first",
    ),
    Variable(
        name="informed",
        reference=7,
        kind="Boolean",
        said="false while the estimate rests on what was believed beforehand",
    ),
    Variable(
        name="status",
        reference=8,
        kind="Integer",
        said="what became of the sample: 0 where it was used, else flags as the C header has them",
    ),
)


def variables_of(torque: str) -> tuple[Variable, ...]:
    """Inputs and outputs; a rate is of no use where it is estimated, beside a steering torque."""
    measured = Variable(name=torque, reference=2, kind='Real unit="N.m"', said=TORQUES[torque])
    return (PSI, *(() if torque == "M" else (RATE,)), measured, LOAD, *OUTPUTS)
