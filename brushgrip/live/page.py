"""The page in the browser: friction now, friction over time, torque over angle, a button to record.

By a Bokeh server: it runs in this process, streams new points alone, and needs no build of its own.
"""

import socket
from collections.abc import Callable
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from brushgrip.live.estimate_ring import EstimatePoints
from brushgrip.live.session import Session
from brushgrip.live.session_state_in_words import State, friction_of, usability_of
from brushgrip.wording.friction_in_words import with_95_band
from observers.estimates import BAND_STDS
from symbolic import InvalidInputError

PERIOD = 50
"""Between updates [ms]."""
PICTURES = 4
"""One of so many updates is of the pictures, which take longest; the others are of the words alone."""
GRID = 0.01
"""Between points in the pictures [s]; at higher rates they show some of the samples."""
SHOWN = 3_000
"""Points in the pictures, 30 s at 100 Hz."""
MIN_AXIS_TOP = 1.5
"""Least friction at the top of the picture [1]."""
HEAD = """{% extends base %}{% block postamble %}
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
:root { color-scheme: light dark } body { margin: 0; background: #fff; color: #000 }
@media (prefers-color-scheme: dark) { body { background: #000; color: #fff } }
</style>
<script>
window.shown = Date.now()
setInterval(() => {
  if (Date.now() - window.shown > 5000) fetch(location.href).then(() => location.reload(), () => {})
}, 2000)
</script>{% endblock %}"""
"""A page that has shown nothing new for 5 s is loaded anew where the program answers: after a broken
connection, or while it lay in the background."""
STYLE = Path(__file__).with_name("page.css")
TURNED = """:host { overflow: hidden }
@media (prefers-color-scheme: dark) { :host { filter: invert(1) hue-rotate(180deg) } }"""
"""What is drawn for a white page, on a dark one."""
CUT_OFF = '<span class="cut-off">not usable: this page is cut off</span>'
"""In place of "usable" where the words are not replaced for a second, by an animation of the style: of
what runs no more, or cannot be reached, nothing else would say so."""
SHOWN_BY_BROWSER = """
requestAnimationFrame(() => setTimeout(() => { sent.text = sent.name; window.shown = Date.now() }))"""
"""The browser says, once it is drawn, which update it shows: a slow one gets no other before, or it
would show what is long past from a queue."""
COLUMNS = (
    *("t", "mu", "low", "high", "usable_mu", "usable_low", "usable_high"),
    *("psi", "torque", "predicted"),
)


class LiveView:
    """View of a session in one browser."""

    def __init__(self, session: Session) -> None:
        """Begin with what is still in memory."""
        models = import_module("bokeh.models")
        self._session, self._at, self._stretch = session, 0, 0.0
        style = STYLE.read_text("utf-8")
        self.points = models.ColumnDataSource({name: [] for name in COLUMNS})
        self.words = models.Div(stylesheets=[style], sizing_mode="stretch_width")
        # Its name is the number of the last update, its text that of the one that is shown.
        self.sent = models.Div(name="0", text="0", visible=False)
        self.sent.js_on_change("name", models.CustomJS(args={"sent": self.sent}, code=SHOWN_BY_BROWSER))
        self.button = models.Button(label="", stylesheets=[style], align="center")
        self.button.on_click(lambda: setattr(session, "recording", not session.recording))
        self._top = models.Range1d(0.0, MIN_AXIS_TOP)

    def layout(self) -> Any:
        """The models of the page."""
        layouts = import_module("bokeh.layouts")
        parts = [self.words, self._friction_figure(), self._torque_figure(), self.button]
        return layouts.column(*parts, sizing_mode="stretch_width")

    def update(self) -> None:
        """Bring words or pictures up to date, at first both, once the browser shows the last ones."""
        if self.sent.text != self.sent.name:
            return
        number = int(self.sent.name)
        if number % PICTURES == 0:
            self._update_pictures()
        if number % PICTURES or number == 0:
            # Bokeh sends what is set, but not what is as before.
            self.words.text = friction_html(self._session.state(), self._session.estimator.columns)
            self.button.label = "Stop recording" if self._session.recording else "Record"
        self.sent.name = str(number + 1)

    def mark_first_update_shown(self, _: Any) -> None:
        """The browser shows what it found when it opened the page."""
        self.sent.text = self.sent.name

    def _update_pictures(self) -> None:
        new = self._session.ring.since(max(self._at, self._session.ring.end - 20 * SHOWN))
        self._at = new.end
        if len(new.values):
            self.points.stream(self._thinned_columns(new), SHOWN)
            usable = np.asarray(self.points.data["usable_high"], dtype=float)
            self._top.end = max(MIN_AXIS_TOP, 1.05 * float(np.nanmax(usable, initial=0.0)))

    def _thinned_columns(self, new: EstimatePoints) -> dict[str, Any]:
        """The last point of every `GRID`, the newest one among them."""
        last = np.diff(np.floor(new.t / GRID), append=np.inf) != 0
        new = EstimatePoints(new.end, new.values[last])
        mu_eff, std = new.values_of_field("mu_eff"), new.values_of_field("mu_eff_std")
        known = np.isfinite(mu_eff)
        mu, std = (
            np.where(known, mu_eff, new.values_of_field("mu")),
            np.where(known, std, new.values_of_field("mu_std")),
        )
        usable = (new.values_of_field("usable") == 1) & self._session.has_plausible_columns
        sign = -1.0 if "M" in self._session.estimator.columns else 1.0
        # Between stretches no line.
        begins = np.diff(new.values_of_field("stretch"), prepend=self._stretch) != 0
        self._stretch = float(new.values_of_field("stretch")[-1])
        low, high = np.maximum(mu - BAND_STDS * std, 0.0), mu + BAND_STDS * std
        shown = zip(("usable_mu", "usable_low", "usable_high"), (mu, low, high), strict=True)
        return {
            "t": new.t,
            "mu": np.where(begins, np.nan, mu),
            "low": low,
            "high": high,
            **{name: np.where(usable, values, np.nan) for name, values in shown},
            "psi": np.degrees(new.values_of_field("psi")),
            "torque": sign * new.values_of_field("torque"),
            "predicted": np.where(begins, np.nan, new.values_of_field("M_z_predicted")),
        }

    def _friction_figure(self) -> Any:
        figure = _figure("time [s]", "friction μ_eff", y_range=self._top)
        for begin, colour, name, line in (
            ("", "#777777", "not usable", {"line_width": 2, "line_dash": "dotted"}),
            ("usable_", "#0072b2", "usable, with its 95 % band", {"line_width": 5}),
        ):
            drawn = {"source": self.points, "legend_label": name}
            band = {"fill_color": colour, "fill_alpha": 0.3 if begin else 0.1}
            low, high = (f"{begin}{end}" for end in ("low", "high"))
            figure.varea("t", low, high, **band, **drawn)
            figure.line("t", f"{begin}mu", color=colour, **line, **drawn)
        figure.legend.location, figure.legend.orientation = "bottom_right", "horizontal"
        return figure

    def _torque_figure(self) -> Any:
        figure = _figure("angle [°]", "torque of the ground [N m]")
        drawn = {"source": self.points}
        figure.scatter("psi", "torque", color="#555555", size=5, legend_label="measured", **drawn)
        figure.line("psi", "predicted", color="#d55e00", line_width=3, legend_label="model", **drawn)
        return figure


def friction_html(state: State, recorded_columns: tuple[str, ...]) -> str:
    """Friction, whether it may be used, and what to do, as HTML; texts of the source are escaped."""
    mu, std = friction_of(state.estimate)
    value, sign, within = ("–" if std >= mu else with_95_band(mu, std)).partition(" ± ")
    counts = ", ".join(f"{count} {name}" for name, count in state.counts.items())
    recording = state.recording and f"recording {state.recording}"
    lines = (state.note, state.status, recording, counts, ", ".join(recorded_columns))
    small = "".join(f"<p>{escape(line)}</p>" for line in lines if line)
    data = {"t": state.t, "mu": mu, "std": std}
    digits = " ".join(f'data-{name}="{float(value)!r}"' for name, value in data.items())
    return (
        f'<div class="now {usability_of(state).replace(" ", "-")}" {digits}>'
        "<p>friction μ_eff ± 95 % band</p>"
        f'<div class="mu">{value} <small>{sign}{within}</small></div>'
        f'<div class="verdict"><span>{usability_of(state)}</span>{CUT_OFF}</div>'
        f'<p class="advice">{escape(state.advice)}</p>{small}</div>'
    )


def serve_page(session: Session, host: str, port: int, opened: Callable[[str], None]) -> None:
    """Serve the page until the process is interrupted; `opened` is called with its address."""
    try:
        application, function, server = (
            import_module(f"bokeh.{name}")
            for name in ("application", "application.handlers", "server.server")
        )
    except ImportError:
        raise InvalidInputError("the page needs Bokeh; pip install 'brushgrip[live]'") from None

    def show(document: Any) -> None:
        view = LiveView(session)
        document.title, document.template = "brushgrip live", import_module("jinja2").Template(HEAD)
        document.add_root(view.layout())
        document.add_root(view.sent)
        view.update()
        document.on_event("document_ready", view.mark_first_update_shown)
        document.add_periodic_callback(view.update, PERIOD)

    page = application.Application(function.FunctionHandler(show))
    everywhere = host in ("0.0.0.0", "::", "")
    names = ["*"] if everywhere else [host, "localhost", "127.0.0.1"]
    try:
        with socket.socket() as free:
            free.bind((host, port))
            port = free.getsockname()[1]
        origins = [f"{name}:{port}" for name in names]
        running = server.Server({"/": page}, address=host, port=port, allow_websocket_origin=origins)
    except OSError as error:
        raise InvalidInputError(f"{host}:{port}: no page can be served there: {error}") from None
    running.start()
    try:
        opened(f"http://{'localhost' if everywhere else host}:{running.port}/")
        running.io_loop.start()
    finally:
        running.stop()
        running.unlisten()


def _figure(x: str, y: str, **options: Any) -> Any:
    figure = import_module("bokeh.plotting").figure(
        height=320, sizing_mode="stretch_width", x_axis_label=x, y_axis_label=y, tools="pan,wheel_zoom",
        toolbar_location=None, stylesheets=[TURNED], **options,
    )  # fmt: skip
    for axis in figure.axis:
        axis.axis_label_text_font_size = axis.major_label_text_font_size = "16px"
        axis.axis_label_text_color = axis.major_label_text_color = "#000000"
    return figure
