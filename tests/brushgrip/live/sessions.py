"""What tests of live estimation share: a recording, sessions over it, what `estimate` says."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from brushgrip.estimation.observe_recording import observe, observer_factory
from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.live.mapped_columns import Row
from brushgrip.live.session import Session
from brushgrip.live.session_setup import source_and_estimator
from brushgrip.live.session_state_in_words import State
from observers import ESTIMATE, Estimate, Estimates
from tests.processes import wait_for

RECORDINGS = Path(__file__).parents[3] / "examples" / "recordings"
RIG = RECORDINGS / "rig.toml"


def rows_of(samples: int, begin: int = 0) -> list[dict[str, float]]:
    """The first samples of a recording of the demo, which turn the wheel from the 150th on."""
    t, psi, M_z, F_N = np.loadtxt(RECORDINGS / "train_a.csv", delimiter=",", skiprows=1).T
    columns = {"t": t, "psi": psi, "M_z": M_z, "F_N": F_N}
    kept = {name: values[begin : begin + samples].tolist() for name, values in columns.items()}
    return [dict(zip(kept, row, strict=True)) for row in zip(*kept.values(), strict=True)]


def session_of(
    spec: str, observer: str = "ekf", *, record: Path | None = None, **options: Any
) -> Session:
    """A session on a source; options of `gather_inputs`, and speed."""
    speed = options.pop("speed", 1.0)
    inputs = gather_inputs(**({"rig": RIG} | options))
    observers = observer_factory(ObserverName(observer))
    opened, estimator = source_and_estimator(spec, inputs, observers, speed=speed)
    return Session(opened, estimator, record=record)


def state_of(estimate: Estimate | None = None, **more: Any) -> State:
    """A state of a session, not usable and without a word."""
    silent: dict[str, Any] = {"status": "", "advice": "", "recording": "", "counts": {}}
    return State(**{"t": 1.0, "estimate": estimate, "usable": False, "ended": False} | silent | more)


class ListSource:
    """Gives rows once, then ends, or is lost."""

    waits, refused, fault = True, 0, ""

    def __init__(self, rows: Iterable[Row], end: type[Exception] = EOFError) -> None:
        """Of these rows, and how it ends."""
        self._rows, self._end = list(rows), end

    def read(self) -> list[Row]:
        if not self._rows:
            raise self._end("gone")
        taken, self._rows = self._rows[:50], self._rows[50:]
        return taken

    def close(self) -> None:
        pass


def run_to_end(session: Session) -> Session:
    """Start, wait for the end of the source, stop."""
    session.start()
    wait_for(lambda: session.state().ended)
    session.stop()
    return session


def estimated(path: Path, observer: str = "ekf", **options: Any) -> Estimates:
    """What `brushgrip estimate` says of a file; options of `gather_inputs`."""
    inputs = gather_inputs([str(path)], **({"rig": RIG} | options))
    (recording,) = inputs.recordings(causal=True, torque_required=False)
    return observe(observer_factory(ObserverName(observer)), recording, inputs.read_found_model())


def same_to_the_last_digit(session: Session, said: Estimates) -> None:
    """What the session showed, of its last stretch, is what `estimate` says."""
    points = session.ring.since(0)
    points = session.ring.since(0, int(points.values_of_field("stretch")[-1]))
    np.testing.assert_array_equal(points.t, said.t)
    for name in ESTIMATE:
        np.testing.assert_array_equal(points.values_of_field(name), getattr(said, name), err_msg=name)
