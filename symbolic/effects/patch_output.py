"""Output of the patch at one sample, before the torque that is added last."""

from dataclasses import dataclass

from symbolic.deformation import Expression


@dataclass(frozen=True, kw_only=True)
class PatchOutput:
    """Output of patch and effects at one sample; CasADi expressions.

    Attributes:
        M_z: aligning torque so far [N m].
        slide: 3/8 F_N a, the full slide torque at mu = 1 [N m].
        mu: coefficient of friction [1].
    """

    M_z: Expression
    slide: Expression
    mu: Expression
