import pytest

from identification import Recording
from identification.selection.trial import TrialTask, run_trial
from tests.identification.factories import read_campaign
from tests.identification.selection.compared import Pair


@pytest.fixture(scope="module")
def pair() -> Pair:
    recordings = read_campaign(None, 1)[1][:2]
    return run_trial(TrialTask((), recordings[:1], recordings[1:])), recordings


@pytest.fixture(scope="module")
def damped() -> list[Recording]:
    return read_campaign("contact_damping", 3, duration=6.0)[1]
