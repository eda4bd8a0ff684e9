import pytest

from identification import Recording
from identification.selection.trials import Trial, TrialTask, run_trial
from tests.identification.factories import read_campaign


@pytest.fixture(scope="module")
def pair() -> tuple[Trial, list[Recording]]:
    recordings = read_campaign(None, 1)[1][:2]
    return run_trial(TrialTask((), recordings[:1], recordings[1:])), recordings
