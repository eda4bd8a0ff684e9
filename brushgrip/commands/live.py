"""`brushgrip live`."""

import time
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from brushgrip.commands.options import (
    ChannelMap,
    EffectModules,
    ModelFile,
    ObserverUsed,
    RigFile,
    StiffnessState,
    TuningProfile,
    TuningValues,
    VehicleFile,
    option,
    output_file_option,
)
from brushgrip.inputs.option_choices import ObserverName

if TYPE_CHECKING:
    from brushgrip.live.friction_sender import FrictionSender
    from brushgrip.live.session import Session


@dataclass(frozen=True, kw_only=True)
class LiveRequest:
    """Estimate friction while it is measured, and show it on a page in the browser.

    SOURCE is a recording, replayed in real time (replay:FILE, or FILE alone); can:INTERFACE:CHANNEL, a
    bus that python-can knows, such as can:socketcan:can0, with --dbc; udp:PORT or udp:HOST:PORT, lines
    of text in datagrams; or - for lines on standard input. Lines are JSON objects, {"t": 0.01, "psi":
    0.02, "M_z": -0.7, "F_N": 560}, or CSV behind a header. Names, units and times are mapped by --map.

    The estimate is that of `estimate` on the recorded file. Friction is for use while usable is said.
    The page is for this machine alone unless --host says otherwise, and controls nothing but the
    recording. Ctrl-C ends; with --no-page, which prints a line a second, so does the end of a file.
    """

    source: Annotated[str, typer.Argument(metavar="SOURCE", show_default=False)]
    rig: RigFile = None
    vehicle: VehicleFile = None
    model: ModelFile = None
    channel_map: ChannelMap = None
    effects: EffectModules = None
    ground: str | None = option("--ground", help="What the wheel stands on.")
    observer: ObserverUsed = ObserverName.EKF
    tuning: TuningProfile = None
    tune: TuningValues = None
    stiffness_state: StiffnessState = None
    dbc: Path | None = option("--dbc", "DBC", "Database of the signals of a CAN bus.")
    speed: float = option("--speed", "N", "Replay a file so many times as fast.", default=1.0)
    record: Path | None = output_file_option(
        "--record",
        "OUT.parquet",
        "Record from the beginning, as Parquet or MDF4 (OUT.mf4); where the file is there, or the"
        " source begins anew, to OUT_2 and so on.",
    )
    target: str | None = option(
        "--target", "SHARE", "Advise where to turn until friction is known to it, as 10%."
    )
    limit: list[str] | None = option("--limit", "NAME=VALUE", "What the wheel may do then, as of plan.")
    send: list[str] | None = option(
        "--send",
        "TO",
        "Send friction to can:INTERFACE:CHANNEL, or as JSON to udp:HOST:PORT. May be repeated.",
    )
    send_dbc: Path | None = output_file_option(
        "--send-dbc", "DBC", "Write the database of the CAN frames sent."
    )
    host: str = option(
        "--host",
        help="Address to serve the page at; 0.0.0.0 for other machines too.",
        default="127.0.0.1",
        show_default=True,
    )
    port: int = option(
        "--port", min=0, default=5006, max=65535, help="Port of the page; 0 for any.", show_default=True
    )
    no_browser: bool = option("--no-browser", help="Serve the page, but open no browser.", default=False)
    no_page: bool = option("--no-page", help="Serve no page; print a line a second.", default=False)

    def run(self) -> None:
        """Follow the source until it is told to end."""
        from brushgrip.live.friction_sender import DATABASE, FrictionSender
        from brushgrip.outputs.atomic import staged_file, write_utf8

        if self.send_dbc is not None:
            with staged_file(self.send_dbc) as stage:
                write_utf8(stage, DATABASE)
        with ExitStack() as stack:
            senders = [stack.enter_context(closing(FrictionSender(spec))) for spec in self.send or ()]
            self._run(self._session(tuple(senders)))

    def _run(self, session: "Session") -> None:
        from brushgrip.live.session_state_in_words import state_line
        from brushgrip.outputs.console import print_line, show_json

        try:
            if self.no_page:
                session.start()
                while not (state := session.state()).ended:
                    print_line(state_line(state))
                    time.sleep(1.0)
            else:
                self._serve(session)
        except KeyboardInterrupt:
            print_line("ended")
        finally:
            session.stop()
            if session.has_begun:
                state = session.state()
                print_line(state_line(state))
                print_line(", ".join(f"{number} {name}" for name, number in state.counts.items()))
                for path in session.recorded:
                    print_line(f"wrote {path}")
                show_json({"counts": state.counts, "wrote": [str(path) for path in session.recorded]})

    def _session(self, senders: "tuple[FrictionSender, ...]") -> "Session":
        from brushgrip.estimation.observe_recording import aligning_measurement_model, observer_factory
        from brushgrip.inputs.command_inputs import gather_inputs
        from brushgrip.inputs.option_values import chosen_limits, chosen_tuning, parse_share
        from brushgrip.live.recorder import writer_for
        from brushgrip.live.session import Session
        from brushgrip.live.session_setup import source_and_estimator
        from brushgrip.live.steering_adviser import SteeringAdviser

        if self.record is not None:
            writer_for(self.record)
        inputs = gather_inputs(
            rig=self.rig, vehicle=self.vehicle, model=self.model, channel_map=self.channel_map,
            effects=self.effects,
        )  # fmt: skip
        signals = replace(inputs.signals, dbc=self.dbc or inputs.signals.dbc)
        aligning = aligning_measurement_model(by_direction=False, stiffness_state=self.stiffness_state)
        tuning = chosen_tuning(self.tuning, self.tune)
        factory = observer_factory(self.observer, tuning, aligning)
        limits = chosen_limits(self.limit)
        adviser = None if self.target is None else SteeringAdviser(parse_share(self.target), limits)
        opened, estimator = source_and_estimator(
            self.source, replace(inputs, signals=signals), factory, speed=self.speed, ground=self.ground,
            adviser=adviser,
        )  # fmt: skip
        return Session(opened, estimator, record=self.record, adviser=adviser, listeners=senders)

    def _serve(self, session: "Session") -> None:
        """The page, until it is interrupted; the source is opened once it is there."""
        import webbrowser

        from brushgrip.live.page import serve_page
        from brushgrip.outputs.console import print_line

        def opened(address: str) -> None:
            session.start()
            print_line(f"page at {address} (Ctrl-C ends)")
            if not self.no_browser:
                webbrowser.open(address)

        serve_page(session, self.host, self.port, opened)
