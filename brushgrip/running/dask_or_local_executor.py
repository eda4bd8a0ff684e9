"""The processes of a cluster, by the address of its scheduler."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from identification.selection.trial_runner import worker_pool
from symbolic import BrushgripError, InvalidInputError

PATIENCE = "20s"
"""Time without an answer after which a scheduler counts as absent [s]."""


@contextmanager
def cluster_or_local_executor(
    address: str | None, jobs: int | None = None, start: int = 0
) -> Iterator[Executor | None]:
    """The executor of a Dask cluster; for no address `worker_pool` of this machine, None for one job.

    A worker that is lost costs time alone: Dask gives its work to another. The workers need the same
    version of brushgrip, and to see files under the same paths.
    """
    if address is None:
        with worker_pool(jobs, start) as pool:
            yield pool
        return
    client = _client(address)
    from distributed import KilledWorker
    from distributed.comm.core import CommClosedError

    try:
        yield client.get_executor()
    except (KilledWorker, CommClosedError) as error:  # Workers keep dying; the connection is lost.
        raise BrushgripError(f"--scheduler {address}: {error}") from error
    finally:
        client.close()


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise InvalidInputError(
            "--scheduler needs dask.distributed: pip install 'brushgrip[cluster]'"
        ) from None
    try:
        client: Any = Client  # Without annotations.
        return client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error) or type(error).__name__
        raise InvalidInputError(
            f"--scheduler {address}: no scheduler answers there ({reason}); give the address that"
            " 'dask scheduler' prints, such as tcp://10.0.0.1:8786"
        ) from None
