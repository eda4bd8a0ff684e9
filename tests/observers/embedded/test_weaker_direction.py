"""What the weaker direction of turning holds less, beside the estimate of generated code."""

import re
from pathlib import Path

import pytest

from observers import AligningTorque, DirectionalFriction, Ekf
from observers.embedded import DOUBLE, generate, generate_fmu
from observers.embedded.fmu import is_supported_host
from symbolic import compiler
from tests.observers.embedded.generated_code import DECLARED, observer_of
from tests.observers.factories import found_model

UNLIKE = found_model({"asymmetric_friction.ratio": 0.85}, bristles=8)
needs_fmu = pytest.mark.skipif(
    not is_supported_host() or compiler() is None, reason="no FMU can be built"
)


def defined(header: str) -> list[float]:
    """What a header defines as the share."""
    return [float(value) for value in re.findall(r"#define BRUSHGRIP_WEAKER (\S+)", header)]


def test_the_header_has_the_share_or_says_why_not(tmp_path: Path) -> None:
    header = tmp_path / "brushgrip.h"
    unlike = observer_of(Ekf, UNLIKE, AligningTorque())

    # 1 and 0.85 have the mean 0.925.
    for model, share in ((DECLARED, 0.0), (UNLIKE, 0.075 / 0.925)):
        generate(observer_of(Ekf, model, AligningTorque()), tmp_path, DOUBLE)
        assert defined(header.read_text()) == [pytest.approx(share)]
    generate(unlike, tmp_path, DOUBLE, tunable="all")
    assert defined(header.read_text()) == []
    assert "with r the parameter asymmetric_friction_ratio," in header.read_text()
    assert "    double asymmetric_friction_ratio; " in header.read_text()
    generate(unlike, tmp_path, DOUBLE, tunable="tuning")
    assert defined(header.read_text()) == [pytest.approx(0.075 / 0.925)]
    generate(observer_of(Ekf, UNLIKE, DirectionalFriction()), tmp_path, DOUBLE)
    assert defined(header.read_text()) == []
    assert "friction has a state for each direction" in header.read_text()


@needs_fmu
@pytest.mark.long
def test_an_fmu_has_it_as_an_output(tmp_path: Path) -> None:
    pytest.importorskip("fmpy", reason="fmpy simulates the FMU")
    import fmpy

    unlike = observer_of(Ekf, UNLIKE, AligningTorque())
    given = {"stop_time": 0.02, "output_interval": 0.01, "output": ["weaker"]}

    archive = generate_fmu(unlike, tmp_path, DOUBLE)
    assert fmpy.simulate_fmu(str(archive), **given)["weaker"] == pytest.approx(0.075 / 0.925)
    archive = generate_fmu(unlike, tmp_path, DOUBLE, tunable="all", name="tuned")
    given["start_values"] = {"parameters.asymmetric_friction_ratio": 2.0}
    assert fmpy.simulate_fmu(str(archive), **given)["weaker"] == pytest.approx(1 / 3)
