import json
import math
import select
import socket
from dataclasses import replace
from pathlib import Path

import pytest

from brushgrip.live.friction_sender import DATABASE, IDENTIFIER, can_frame, json_datagram
from brushgrip.live.session_state_in_words import State
from identification import read_recording, read_rig
from observers import Ekf, Estimate, Status, from_files
from observers import run as observe
from tests.brushgrip.helpers import Run
from tests.brushgrip.live.sessions import RIG, state_of


def state(mu: float, std: float, *, usable: bool = True, status: Status = Status.USED) -> State:
    of_mu = {"mu": mu, "mu_std": std, "mu_eff": mu, "mu_eff_std": std}
    estimate = Estimate(**of_mu, M_z_predicted=0.0, informed=True, status=status)
    return state_of(estimate, usable=usable)


@pytest.mark.parametrize(
    ("mu", "std", "usable"),
    [
        (0.8125, 0.0312, True),
        (0.0, 0.0, False),
        (6.6, 0.01, True),
        (math.nan, 0.1, True),
        (1.0, -1.0, True),
    ],
)
def test_a_frame_says_by_its_database_what_the_state_is(mu: float, std: float, usable: bool) -> None:
    cantools = pytest.importorskip("cantools", reason="needs brushgrip[live]")
    message = cantools.database.load_string(DATABASE, "dbc").get_message_by_frame_id(IDENTIFIER)
    given = replace(state(mu, std, usable=usable, status=Status.SUSPECT), weaker=0.081)
    said = message.decode(can_frame(given, 258), scaling=True)
    highest = message.get_signal_by_name("mu_eff").maximum
    within = 0 <= mu <= 6.5534 and 0 <= std <= 6.5534

    assert (said["counter"], said["status"]) == (2, Status.SUSPECT)
    assert said["usable"] == (usable and within)
    # Never less than it is.
    assert said["weaker"] == pytest.approx(0.09)
    assert json.loads(json_datagram(given))["weaker"] == 0.081
    if within:
        assert (said["mu_eff"], said["mu_eff_std"]) == (pytest.approx(mu), pytest.approx(std))
    else:
        assert max(said["mu_eff"], said["mu_eff_std"]) > highest


@pytest.mark.long
def test_friction_is_sent_while_it_is_measured(run: Run) -> None:
    can = pytest.importorskip("can", reason="needs brushgrip[live]")
    wheel = read_recording(RIG.with_name("train_a.csv"), read_rig(RIG))
    # Compiles the step, which samples would wait for until they are too old.
    estimates = observe(from_files(Ekf, RIG), wheel.t, wheel.psi, wheel.F_N, wheel.M_z, one_by_one=True)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
        can.Bus(interface="virtual", channel="sent") as bus,
    ):
        receiver.bind(("127.0.0.1", 0))
        send = [f"udp:{receiver.getsockname()[1]}", "can:virtual:sent"]
        outcome = run(
            "live", RIG.with_name("train_a.csv"), "--rig", RIG, "--speed", 20, "--no-page",
            "--send", send[0], "--send", send[1], "--send-dbc", "friction.dbc",
        )  # fmt: skip
        told = []
        while select.select([receiver], [], [], 0)[0]:
            told.append(json.loads(receiver.recv(4096)))
        frames = list(iter(lambda: bus.recv(0), None))

    assert outcome.status == 0
    assert Path("friction.dbc").read_text() == DATABASE
    assert any(one["usable"] for one in told)
    assert not told[-1]["usable"]
    assert told[-1]["mu_eff"] == pytest.approx(estimates.mu_eff[-1])
    # Each keeps its own time between two messages.
    assert min(len(frames), len(told)) > 10
    assert [frame.data[5] for frame in frames] == [number % 256 for number in range(1, len(frames) + 1)]
