"""Ctrl-C, SIGTERM and a closed terminal, at any instant of a process."""

import gc
import signal
import sys
from collections.abc import Callable
from types import FrameType

INTERRUPTED = 130
"""Exit status of a process that was told to end, as shells have it."""
_BETWEEN_LOOKS = 0.002
"""While an interruption waits, how often it is looked whether it may come [s]."""
_IMPORT_SYSTEM = "<frozen importlib._bootstrap>"
_CASADI = "casadi.py"


class InterruptHandler:
    """Raises KeyboardInterrupt once, where Python code can handle it; not after `stop_interrupting`.

    Amid an import, compiled code would print it as a fault; amid a function of CasADi's module, which
    its compiled code may have called, it would be lost. There it waits until that is done, unless it
    comes again. Raised in a destructor it would be printed and lost: it is raised once more.
    """

    def __init__(self) -> None:
        """Nothing has been heard yet."""
        self.is_over = False
        self._waits = False
        self._print_unraisable = sys.unraisablehook

    def install_signal_handlers(self) -> None:
        """Hear the signals from now on, those that the process was started deaf to excepted."""
        for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):
            handler = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) == handler:
                signal.signal(number, self._on_signal)
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, self._on_timer)
            sys.unraisablehook = self._on_unraisable

    def stop_interrupting(self) -> None:
        """Interrupt nothing from now on: at its end Python would print a traceback."""
        self.is_over = True
        if self._waits:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def raise_pending_interrupt(self) -> None:
        """Interrupt now what was told to end while it was imported."""
        if self._waits:
            self._interrupt()

    def _on_signal(self, _number: int, frame: FrameType | None) -> None:
        if self.is_over:
            return
        if not self._waits and hasattr(signal, "setitimer") and _is_in_import_or_casadi(frame):
            self._start_retry_timer()
        else:
            self._interrupt()

    def _on_timer(self, _number: int, frame: FrameType | None) -> None:
        if self.is_over or not _is_in_import_or_casadi(frame):
            self._interrupt()

    def _on_unraisable(self, fault: "sys.UnraisableHookArgs") -> None:
        if not issubclass(fault.exc_type, KeyboardInterrupt):
            self._print_unraisable(fault)
        elif not self.is_over:
            self._start_retry_timer()

    def _start_retry_timer(self) -> None:
        self._waits = True
        signal.setitimer(signal.ITIMER_REAL, _BETWEEN_LOOKS, _BETWEEN_LOOKS)

    def _interrupt(self) -> None:
        if self._waits:
            self._waits = False
            signal.setitimer(signal.ITIMER_REAL, 0)
        if not self.is_over:
            raise KeyboardInterrupt


def _is_in_import_or_casadi(frame: FrameType | None) -> bool:
    """Whether a frame is of CasADi, or of an import."""
    if frame is not None and frame.f_code.co_filename.endswith(_CASADI):
        return True
    while frame is not None:
        if frame.f_code.co_filename == _IMPORT_SYSTEM:
            return True
        frame = frame.f_back
    return False


def run_command_and_exit(load: Callable[[], Callable[[], None]]) -> None:
    """Runs the command that `load` imports and exits, with status 130 where it was told to end."""
    interruptions = InterruptHandler()
    try:
        try:
            interruptions.install_signal_handlers()
            command = load()
            interruptions.raise_pending_interrupt()
            command()
        finally:
            interruptions.stop_interrupting()
            # Nothing is collected as the process ends, which would take half a second.
            gc.freeze()
    except KeyboardInterrupt:
        interruptions.stop_interrupting()
        raise SystemExit(INTERRUPTED) from None
    raise SystemExit(0)
