"""What has been made of a sample before the torque that is added last."""

from dataclasses import dataclass

from symbolic.deformation import Expression


@dataclass(frozen=True, kw_only=True)
class PatchOutput:
    """What patch and effects have made of a sample; casadi expressions.

    Attributes:
        M_z: aligning torque so far [N m].
        slide: 3/8 F_N a, the full slide torque at mu = 1 [N m].
        mu: coefficient of friction [1].
    """

    M_z: Expression
    slide: Expression
    mu: Expression
