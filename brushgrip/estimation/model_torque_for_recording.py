"""The torque that a model, declared or found, predicts for a recording."""

import numpy as np
from numpy.typing import NDArray

from identification import FoundModel, Recording, Values, replaced_rig, signals_of
from symbolic import InvalidInputError, Model, simulate
from symbolic.trajectory_sensitivity import final_full_slide_memory


def simulation_model_and_values(
    recording: Recording, found: FoundModel | None, given: float | None = None
) -> tuple[Model, dict[str, float]]:
    """The model for a recording, declared or found, and the values of all its parameters.

    A friction coefficient that is given [1] goes before every other; without any, mu is not known.
    """
    mu = recording.tyre.mu if given is None else given
    if found is not None:
        values = found.values_for_recording(recording.name, mu, recording.ground)
        return found.model, values if given is None else values | {"mu": given}
    if mu is None:
        raise InvalidInputError(
            f"{recording.name}: mu is not known; give it with --mu, under [tyre] of the rig file, "
            "as '# mu = 1.2' before a CSV header, or name a model file (--model)"
        )
    return Model(), {"mu": mu, "k": recording.tyre.k}


def simulated_torque(
    recording: Recording, model: Model, values: dict[str, float], found: FoundModel | None
) -> NDArray[np.float64]:
    """Aligning torque at every sample, shape (n,) [N m], on the rig as the found model corrects it."""
    rig = {} if found is None else found.rig
    actual = replaced_rig(recording, Values(tyre={}, own={}, rig=rig))
    theta = np.asarray(model.theta(values)).ravel()
    torque = simulate(model, signals_of(actual), theta, np.array([actual.rig.a, actual.rig.e]))
    return torque.M_z + rig.get(recording.name, {}).get("zero", 0.0)


def values_in_words(
    recording: Recording, values: dict[str, float], found: FoundModel | None, given: float | None
) -> str:
    """Friction and lengths with which a recording is simulated, and whose they are."""
    own, rig = ({}, {}) if found is None else (t.get(recording.name, {}) for t in (found.own, found.rig))
    fitted, declared = "fitted to this recording", "declared"
    source = "--mu" if given is not None else fitted if "mu" in own else declared
    a, e = rig.get("a", recording.rig.a), rig.get("e", recording.rig.e)
    line = f"{recording.name}: mu = {values['mu']:.4g} ({source}), a = {a:.4g} m and e = {e:.4g} m"
    line += f" ({fitted if rig else declared})"
    if found is None:
        return line
    model, load = found.model, float(np.median(recording.F_N))
    theta = model.theta(values)
    memory = final_full_slide_memory(model, signals_of(recording), np.asarray(theta).ravel())
    mu_eff, _ = model.full_slide(memory, load, theta, [a, e], recording.rig.slide_rate)
    line += "; not known as a file of the model" * (not own)
    return f"{line}; mu_eff, which estimate tells, is {float(mu_eff):.2f} at {load:.0f} N"
