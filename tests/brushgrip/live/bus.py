"""A CAN bus with a database, and a participant that sends its frames."""

import re
from typing import Any

import pytest

DBC = """VERSION ""
NS_ :
BS_:
BU_: rig
BO_ 291 Motion: 4 rig
 SG_ Angle : 0|16@1- (0.01,0) [-90|90] "deg" rig
 SG_ Load : 16|16@1+ (1,0) [0|10000] "N" rig
BO_ 292 Torque: 2 rig
 SG_ Mz : 0|16@1- (0.001,0) [-30|30] "Nm" rig
"""
MAP = "psi=Angle,M_z=Torque.Mz,F_N=Load"


class Bus:
    """The other end of a bus, whose frames may have identifiers of 29 bits that begin at `base`."""

    def __init__(self, *, base: int = 0, **options: Any) -> None:
        """Join by options of python-can; its errors where that is not possible."""
        can = pytest.importorskip("can", reason="needs brushgrip[live]")
        self.message, self.bus, self.base = can.Message, can.Bus(**options), base

    @property
    def database(self) -> str:
        """`DBC` with the identifiers of this bus, as DBC files mark those of 29 bits."""
        mark = self.base and self.base + (1 << 31)
        return re.sub(r"(?<=BO_ )\d+", lambda number: str(int(number[0]) + mark), DBC)

    def send(self, identifier: int, data: bytes, t: float, **flags: Any) -> None:
        given = {"is_extended_id": self.base > 0, "arbitration_id": self.base + identifier} | flags
        self.bus.send(self.message(data=data, timestamp=t, **given))

    def motion(self, degrees: float, newton: int, t: float) -> None:
        number = round(100 * degrees) % 65536
        self.send(291, number.to_bytes(2, "little") + newton.to_bytes(2, "little"), t)

    def torque(self, newton_metres: float, t: float) -> None:
        self.send(292, (round(1000 * newton_metres) % 65536).to_bytes(2, "little"), t)
