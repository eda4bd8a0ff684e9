import pytest


@pytest.fixture(autouse=True, scope="module")
def optimised_swing(optimised: None) -> None:
    """One model swings in hundreds of fits."""
