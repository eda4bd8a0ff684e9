"""Results as text: figures with units, findings in plain words, CSV and JSON."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from statistics import fmean
from typing import Any, TypeGuard

from numpy.typing import NDArray

from identification import Candidate, Diagnosis, FreeDecay, ParameterEstimate
from identification.diagnosis.graded_effects import UNRECORDED_LOAD
from identification.free_decay.results import IdentifiedParameter
from identification.residuals.partial_correlations import MIN_STRUCTURE_SHARE
from identification.thesis import DecrementIdentification
from symbolic import EFFECTS

TWO_DECIMALS_FROM = 0.02
"""Half-width of a band from which on it is given with two decimals, below with three [1]."""
NOTHING = 0.01
"""Share of a large deviation below which a value is no figure [1]."""
MAX_FEW = 4
"""Names that are listed in brackets."""
MAX_UNREFITTED_RATIO = 2.0
"""Largest error with nothing refitted over that after refitting that goes without saying [1]."""
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def effect_words(effect: str) -> str:
    """The name of an effect, or of a family, in words."""
    words = "a load that changes with the angle" if effect == UNRECORDED_LOAD else effect
    return words.replace("_", " ").replace("friction over time", "friction over time and travel")


def listed(words: Sequence[str], last: str = "and") -> str:
    """The words in one phrase: a; a and b; a, b and c."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def bracketed_if_few(names: Sequence[str]) -> str:
    """Names in brackets, behind a blank; empty where they are many."""
    return f" ({listed(names)})" if 0 < len(names) <= MAX_FEW else ""


def sentence(text: str) -> str:
    """The text as a sentence: capital first, full stop last; the name of an effect in words."""
    name, colon, rest = text.partition(":")
    if name in EFFECTS:
        text = effect_words(name) + colon + rest
    text = text[:1].upper() + text[1:]
    return text if not text or text[-1] in ".!?" else f"{text}."


def add_degrees_behind_radians(text: str) -> str:
    """The text with every angle and rate in rad in degrees behind it."""

    def degrees(found: re.Match[str]) -> str:
        own = re.sub(r"[\d.]+", lambda one: f"{math.degrees(float(one[0])):.2g}°", found[1])
        return f"{found[0]} ({own}{found[2] or ''})"

    number = r"[−±]?\d[\d.]*"
    return re.sub(rf"({number}(?:(?:, | and | to ){number})*) rad(/s)?", degrees, text)


def percent(share: float | None) -> str:
    """A share as a percentage, a dash where there is none."""
    return "–" if share is None or not math.isfinite(share) else f"{100 * share:.2f} %"


def torque_error_text(value: float | None) -> str:
    """A torque error without its unit [N m], three significant digits."""
    return "–" if value is None or not math.isfinite(value) else f"{value:#.3g}"


def signed(value: float) -> str:
    """A number with its sign and one decimal, as a difference of BIC."""
    return f"{value:+.1f}".replace("-", "−")


def value_with_std(estimate: ParameterEstimate | IdentifiedParameter) -> str:
    """Value ± standard deviation with the unit, rounded to the deviation's second digit."""
    unit = (
        "" if estimate.unit in ("", "1") else f" {estimate.unit}".replace("^2", "²").replace("^3", "³")
    )
    value, std = estimate.value, estimate.std
    if not math.isfinite(value):
        return f"{'∞' if value > 0 else '−∞' if value < 0 else '–'}{unit}"
    if std is None or not math.isfinite(std) or std <= 0:
        power = _displayed_exponent(abs(value) or 1.0)
        text = f"{value / 10**power:.4g}"
    else:
        power = _displayed_exponent(max(abs(value), std))
        if power > 0 and abs(value) < NOTHING * std:
            return "not determined"
        scaled = std / 10**power
        digits = max(0, 1 - math.floor(math.log10(scaled)))
        text = f"{value / 10**power:.{digits}f} ± {scaled:.{digits}f}"
        text = f"({text})" if power else text
    factor = f"·10{str(power).translate(_SUPERSCRIPTS)}" if power else ""
    return f"{text.replace('-', '−')}{factor}{unit}"


def parameter_list(estimates: Mapping[str, ParameterEstimate], *, from_fit: bool = False) -> str:
    """Several parameters in one line: name = value ± std unit; those `from_fit` have a std."""
    return "; ".join(
        f"{name} {'not determined' if from_fit and e.std is None else f'= {value_with_std(e)}'}"
        for name, e in estimates.items()
    )


def candidate_parameters(candidate: Candidate) -> str:
    """Parameters of a candidate in one line; one at the end of its range has no deviation there."""
    own, ends = candidate.parameters, candidate.at_bound
    texts = [
        f"{name} = {value_with_std(replace(own[name], std=None))} (at the end of its range)"
        if name in ends
        else parameter_list({name: own[name]}, from_fit=True)
        for name in own
    ]
    return "; ".join(texts)


def judging_error_before_and_after(diagnosis: Diagnosis) -> tuple[str, float, float]:
    """The error that judges the model: its name, its size before and after [1], NaN for unknown."""
    kind, key = judging_error_name(diagnosis)
    before, after = (stage.summary()[key] for stage in (diagnosis.before, diagnosis.after))
    return kind, (math.nan if before is None else before), (math.nan if after is None else after)


def unrefitted_error(diagnosis: Diagnosis) -> float | None:
    """Validation error with nothing refitted [1], where refitting hides most of it; else None."""
    nothing, judged = diagnosis.after.unrefitted, diagnosis.after.nrmse
    names = [name for name in nothing if name in judged]
    if not names:
        return None
    error, refitted = (fmean(of[name] for name in names) for of in (nothing, judged))
    hidden = error > MAX_UNREFITTED_RATIO * refitted and error - refitted > MIN_STRUCTURE_SHARE
    return error if hidden else None


def judging_error_name(diagnosis: Diagnosis) -> tuple[str, str]:
    """The error that judges the model: its name, and its key in a summary."""
    if diagnosis.holdout:
        return "validation", "holdout_torque_nrmse"
    if diagnosis.after.left_out:
        return "left-out", "left_out_torque_nrmse"
    return "training", "torque_nrmse"


def residual_structure(diagnosis: Diagnosis) -> str:
    """Whether the residual still has structure, in one sentence."""
    if diagnosis.unexplained.present:
        return "The residual has structure that no known effect explains."
    return "The residual has no structure left that is worth an effect."


def candidate_outcome(diagnosis: Diagnosis, candidate: str) -> str:
    """The outcome for a candidate: added, indistinguishable from an added one, or empty."""
    for number, effect in enumerate(diagnosis.effects, start=1):
        if effect.name == candidate:
            return f"added, no. {number}"
    rivals = [effect_words(e.name) for e in diagnosis.effects if candidate in e.indistinguishable_from]
    return f"indistinguishable from {listed(rivals)}" if rivals else ""


def candidate_reason(diagnosis: Diagnosis, candidate: Candidate) -> str:
    """The outcome for a candidate, and for one that was not added why."""
    outcome = candidate_outcome(diagnosis, candidate.name)
    added = {effect.name: effect for effect in diagnosis.effects}
    if candidate.name in added and diagnosis.effects[0].name != candidate.name:
        alone = "useless alone, " * (candidate.delta_bic > 0)
        return f"{outcome}; {alone}ΔBIC {signed(added[candidate.name].delta_bic)} beside the others"
    if outcome:
        return outcome
    known = EFFECTS.get(candidate.name)
    same = [effect_words(e.name) for e in diagnosis.effects if known and e.family == known.family]
    if same:
        more = " with more parameters" if known and known.flexible else ""
        return f"the same mechanism as {listed(same)}{more}; no clear gain beside it"
    if candidate.delta_bic > 0:
        return "alone not worth its parameters"
    return "no clear gain beside what was added" if diagnosis.effects else "no clear gain"


def worse_recordings(diagnosis: Diagnosis) -> list[str]:
    """Those whose error, or that of being left out, the effects found made larger."""
    pairs = [(getattr(diagnosis.before, e), getattr(diagnosis.after, e)) for e in ("nrmse", "left_out")]
    names = (*diagnosis.recordings, *diagnosis.holdout)
    return [n for n in names if any(n in old and new[n] > old[n] for old, new in pairs)]


def _displayed_exponent(size: float) -> int:
    """The power of ten that stands behind a figure of this size; 0 from 1e-3 to 1e5."""
    return 0 if 1e-3 <= size < 1e5 else math.floor(math.log10(size))


def csv_text(columns: Mapping[str, NDArray[Any]], digits: int = 0) -> str:
    """Columns under their names: floats that round-trip or have so many digits, 0 or 1, NaN empty."""
    lists = [[csv_field(value, digits) for value in values.tolist()] for values in columns.values()]
    rows = [",".join(columns), *(",".join(row) for row in zip(*lists, strict=True))]
    return "\n".join(rows) + "\n"


def csv_field(value: float, digits: int) -> str:
    """A number as `csv_text` writes it."""
    if isinstance(value, int):
        return str(int(value))
    if math.isnan(value):
        return ""
    return f"{value:.{digits}g}" if digits else repr(float(value))


def json_text(content: Any) -> str:
    """Strict JSON; numbers that are not finite become null, half characters their escape sequence."""
    text = json.dumps(_finite(content), indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _finite(content: Any) -> Any:
    if isinstance(content, Mapping):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, Sequence) and not isinstance(content, str):
        return [_finite(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content


def free_decay_document(result: FreeDecay, decrement: DecrementIdentification) -> dict[str, Any]:
    """The result file of `identify`: the identification, and the method of [Györök 2022] beside it."""
    document = result.to_dict()
    for recording, vibration in zip(document["recordings"], decrement.vibrations, strict=True):
        recording |= {"source_omega_n": vibration.omega_n, "source_zeta": vibration.zeta}
    document["recordings_units"] |= {"source_omega_n": "rad/s", "source_zeta": "1"}
    return document | {"source": decrement.to_dict()}


def band_decimals(half: float) -> int:
    """Decimals of a friction's band with this half-width [1], and of what it is made of."""
    return 2 if half >= TWO_DECIMALS_FROM else 3


def is_number(value: object) -> TypeGuard[float]:
    """Whether a cell of a summary holds a number."""
    return isinstance(value, float) and math.isfinite(value)
