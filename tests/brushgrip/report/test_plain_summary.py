"""The mail on a diagnosis: friction, how sure it is, and what to do next."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from brushgrip.estimation.friction_by_both_models import EKF_DECLARED, FrictionByBothModels
from brushgrip.estimation.recording_warnings import MAY_END, SUSPECTED
from brushgrip.outputs.provenance import provenance_of
from brushgrip.published.bundled_files import demo_folder
from brushgrip.report.friction_summary import causes_of_band_text
from brushgrip.report.plain_summary import (
    friction_and_notes,
    next_steps,
    repeatability_in_words,
    summary_mail_parts,
)
from brushgrip.report.tables import friction_by_recording
from brushgrip.report.validity_and_missing_effects import (
    band_caveats,
    demo_recordings_warning,
    notes_not_in_text,
)
from brushgrip.report.what_effects_do import effect_summary
from identification import Diagnosis, ParameterEstimate
from identification.diagnosis.found_vs_declared_stiffness import StiffnessComparison
from identification.diagnosis.from_search import BEYOND_RANGE
from identification.diagnosis.graded_effects import ASSUMED, assumed_tolerances_note
from identification.residuals.full_slide_repeatability import Repeatability
from observers.planning.uncertainty_budget import SLOPE
from observers.tuning import OF_LENGTHS, OF_LOAD
from symbolic import Model, Rig, effects_named
from tests.brushgrip.factories import TRACKS, make_diagnosis, make_outcome, make_track

SPREAD = (("a", -0.02), ("b", 0.0), ("c", 0.02))


def mail(diagnosis: Diagnosis, outcome: FrictionByBothModels, warning: str = "") -> str:
    """The mail and what is to be known before acting on it, a line for each part."""
    parts = [part for some in summary_mail_parts(diagnosis, outcome, warning) for part in some]
    return "\n".join(f"{label}: {' '.join(items)}" for label, items in parts)


def test_friction_of_a_car_is_by_the_inclination_found_with_the_declared_one_beside() -> None:
    found = [make_track(name, 0.82 + off) for name, off in SPREAD]
    declared = [replace(make_track(name, 0.9 + off), label=EKF_DECLARED) for name, off in SPREAD]
    outcome = make_outcome("", tracks=(*found, *declared), grounds={"yard": ("a", "b", "c")})
    car = replace(make_diagnosis(("a", "b", "c"), ()), of_car=True, inclination=0.339)
    text = mail(car, replace(outcome, inclination=0.339))

    assert text.startswith("Use it with care: friction between tyre and ground 0.82 ± ")
    assert (
        "Use this one: by these recordings the steering axes are inclined by 19.4° (inclination = 0.339"
        in text
    )
    assert "not as declared; by the vehicle as declared friction would be 0.90 ± " in text
    assert "; friction above allows for it: " in text
    assert "(1) Check the inclination of the steering axes" in text
    assert "as declared" not in mail(car, outcome)
    assert "allows for it" not in mail(car, outcome)


def test_when_friction_is_known_is_no_gain_where_it_is_known_later() -> None:
    later = replace(TRACKS[0], usable=np.arange(11) == 10)
    outcome = make_outcome("c", tracks=(replace(TRACKS[0], label=EKF_DECLARED), later))
    text = mail(make_diagnosis(), outcome)

    assert "\nRecordings with a value: A value of friction comes out in 1 of 1 recordings (" in text
    assert "(first after 10.0 s" in text
    assert "Gain" not in text


def test_the_paragraph_gives_no_value_that_is_not_usable() -> None:
    tracks = (replace(TRACKS[0], budget={OF_LENGTHS: 0.03, OF_LOAD: 0.04}), *TRACKS[1:])
    judged = make_outcome("c", tracks=tracks, grounds={"ice": ("a", "b", "c", "d")})
    assert causes_of_band_text(judged).startswith(
        "What makes the ± of a recording wide, and by how much it would be smaller without that alone:"
        " what the load may be off, 40 %; what the lengths of contact and caster may be off, 20 %"
        " (these do not add up to 100 %). All"
    )
    text = mail(make_diagnosis(("a", "b", "d"), ("c",)), judged)

    assert "tyre and ground 1.10 ± 0.10 (b) and 1.20 ± 0.10 (a) on ice (from 4 recordings)." in text
    assert (
        "\nHow sure: The truth lies within ± in 95 of 100 cases, if model and tolerances are right.\n"
        in text
    )
    assert "sure: A torque that reads 5 % too high makes friction 5 % too high, a load" in text
    assert "9.00" not in text
    assert "not for driving speed" in text
    assert text.endswith(
        "\nNot known: Friction in c and d; friction in b after 7.0 s (told is the value until then)."
    )
    rest = "(c) An error beyond noise remains, of unknown cause, which the model found leaves out too."
    assert f"{rest}\nTorque, not friction: The error of the calculated torque (not of" in text
    again, other, *rest = next_steps(make_diagnosis(("a", "b", "d"), ("c",)), judged)
    assert again == "record c and d again, turning to and fro until the wheel slides both ways"
    assert other.startswith("as something unknown remains, record at other steering speeds")
    assert rest == []
    assert f"\nTo do first: (1) R{again[1:]}.\nWhat the " in text
    assert f"\nTo do then: (2) A{other[1:]}.\n" in text
    note = "note on ice: no band for a further recording yet, which takes 3 recordings with usable"
    assert friction_and_notes(judged) == ([], [f"{note} friction; here 2 of 4"])
    unknown = replace(judged, tracks=TRACKS[2:], grounds={"ice": ("c", "d")})
    text = mail(make_diagnosis(("d",), ("c",)), unknown)
    assert text.startswith(
        "Nothing to use yet: friction between tyre and ground not known on ice (from 4"
    )
    assert "so is the ±" not in text
    assert "95 of 100" not in text


def test_a_ground_is_told_by_the_band_of_a_further_recording() -> None:
    tracks = (*TRACKS[:2], make_track("c", 1.3))
    judged = make_outcome("c", tracks=tracks, grounds={"ice": ("a", "b", "c"), "": ("d",)})
    # t of two degrees of freedom 4.3027, scatter 0.1; own deviation 0.05.
    half = np.hypot(4.3027 * 0.1 * np.sqrt(4 / 3), 1.96 * 0.05)

    assert friction_and_notes(judged) == (
        [f"ice: mu_eff 1.20 ± {half:.2f} for a further recording, from 3 recordings"],
        [],
    )
    within = (
        "In 95 of 100 cases one more recording like these would give friction within the ±. Nobody has"
        " checked friction in another way."
    )
    text = mail(make_diagnosis(("a", "b", "d"), ("c",)), judged)
    assert f" 1.20 ± {half:.2f} on ice; not known (from 4" in text
    assert (
        f"\nHow sure: {within} Where a recording is named, the truth lies within ± in 95 of 100"
        " cases, if model and tolerances are right.\n"
    ) in text
    assert (
        "\nMore on how sure: A torque that reads 5 % too high makes friction 5 % too high, a load that"
        " is too low about as much; beyond what is declared, that comes on top of the ±. The ± on ice is"
        " wide because 3 recordings"
        " differ, from 1.10 to 1.30" in text
    )
    # Six of the same scatter: t of five degrees of freedom is 2.5706.
    wider = np.hypot(2.5706 * 0.1 * np.sqrt(7 / 6), 1.96 * 0.05)
    assert (
        "Record ice 3 more times, 10 s each like these, at the load that you need friction for:"
        f" ± {half:.2f} would come to about ± {wider:.2f} if" in text
    )
    like = tuple(replace(track, mu=np.full(11, 1.2)) for track in tracks)
    same = mail(make_diagnosis(("a", "b", "d"), ("c",)), replace(judged, tracks=like))
    assert "is wide because" not in same and "more times" not in same  # noqa: PT018
    alone = replace(judged, grounds={"ice": ("a", "b", "c")})
    text = mail(make_diagnosis(("a", "b"), ("c",)), replace(alone, slide_rate=0.1))
    motion = ", turning at 0.1 rad/s"
    assert f"on ice (mean of 3 recordings{motion}).\n" in text
    assert f"{within}\n" in text, "one meaning of 95 of 100, on top and in the paragraph"
    assert judged.to_dict()["after"]["further"]["ice"]["further"] == pytest.approx(half, rel=1e-4)
    assert judged.to_dict()["before"]["further"] == {}


def test_the_paragraph_is_as_sure_as_the_grades() -> None:
    diagnosis = make_diagnosis(("a", "b"), ("c",))
    torsion, offset = diagnosis.effects
    graded = replace(
        diagnosis, effects=(replace(torsion, grade="ambiguous"), replace(offset, grade="weak"))
    )
    text = mail(graded, make_outcome("c", tracks=TRACKS))

    assert (
        "allows for it: (a) The tyre's body yields, or its pressure is spread otherwise (one of these,"
        " not known which). (b) The torque channel has a zero error: −0.12 N m (may be chance). (c)"
        in text
    )
    assert "which of carcass torsion" not in text
    drift = replace(torsion, grade="ambiguous", indistinguishable_from=("friction_drift",))
    other = mail(replace(graded, effects=(drift,)), make_outcome("c", tracks=TRACKS))
    assert (
        "allows for it: (a) The tyre's body yields, or its pressure is spread otherwise or friction"
        " changes with time or with the angle turned (one of these, not known which). (b) An er" in other
    )
    assert "which of carcass torsion or friction drift it is" in other
    assert "whether the weak signs of torque offset are chance" in text
    known = make_outcome("c", tracks=TRACKS[:2])
    assert next_steps(graded, known)[0].startswith("as something unknown remains")
    never = make_outcome("c", tracks=TRACKS)
    little = replace(graded, unexplained=replace(graded.unexplained, structured=0.0))
    much = replace(graded, unexplained=replace(graded.unexplained, structured=1.0))
    assert "turning to and fro" in next_steps(little, never)[0]
    assert "as something unknown" in next_steps(much, never)[0], "why friction is not known"
    stiff = replace(graded, notes=("the fitted stiffness k is 4·10⁶ N/m², 1.8 times the declared one",))
    assert [step[:16] for step in next_steps(stiff, never)] == [
        "whoever keeps th",
        "record c and d a",
        "if something unk",
    ]
    clear = replace(graded, unexplained=replace(graded.unexplained, present=False))
    assert next_steps(clear, known)[0].startswith(
        "record what stands under “Next recording”, which tells carcass torsion from patch width ("
        "recording A, "
    )
    nothing = replace(clear, effects=())
    assert next_steps(nothing, known) == ["nothing"]
    assert "Further recordings: None is needed to find the model." in mail(nothing, known)
    load = replace(offset, grade="ambiguous", indistinguishable_from=("unrecorded_load",))
    first, *_ = next_steps(replace(graded, effects=(load,)), known)
    assert first.startswith("record the load, as one")
    hidden = replace(nothing, after=replace(nothing.after, unrefitted={"c": 0.07}))
    assumed = f"{ASSUMED}: load ± 2 %"
    declare, check = next_steps(replace(hidden, notes=(assumed,)), known)
    assert declare.startswith("find out how well load was measured"), "nothing is wrong: last"
    off = "c: load is at the end of its tolerance, 1.1"
    assert next_steps(replace(hidden, notes=(assumed, off)), known)[0] == check
    alike = replace(hidden, before=replace(hidden.before, unrefitted={"c": 0.08}))
    assert next_steps(replace(alike, notes=(assumed,)), known)[0] == check
    assert check.startswith("check that the validation recordings are of the")
    assert check.endswith("7.00 % of range, most in c (7.00 %)")
    loose = replace(known, tracks=(replace(TRACKS[0], budget={OF_LOAD: 0.04}), TRACKS[1]))
    assert next_steps(nothing, loose)[0].startswith("to narrow the ±, weigh the load")
    assert "weigh" not in causes_of_band_text(loose)
    far = replace(torsion.experiment, times=None)
    unsettled = replace(clear, effects=(replace(torsion, grade="ambiguous", experiment=far),))
    assert next_steps(unsettled, known) == ["nothing"], "nothing settles it"
    told = "Further recordings: A usual manoeuvre, repeated, would not tell carcass torsion from patch"
    assert told in mail(unsettled, known)


def test_play_may_be_removed_or_left_and_a_recording_that_is_asked_for_is_not_denied() -> None:
    tracks = (*TRACKS[:2], make_track("c", 1.3))
    outcome = make_outcome("c", tracks=tracks, grounds={"ice": ("a", "b", "c")})
    sound = make_diagnosis(("a", "b"), ("c",), unexplained=False)
    gap = ParameterEstimate(value=0.0636, std=1e-4, unit="rad")
    play = replace(
        sound.effects[0], name="backlash", parameters={"gap": gap}, experiment=None, grade="strong"
    )
    text = mail(replace(sound, effects=(play,)), outcome)
    assert "\nTo do first: (1) Record ice 3 more times" in text
    assert (
        "\nTo do then: (2) Look for the play of 3.6° or 0.064 rad from end to end between angle"
        " sensor and tyre and remove it (then record everything again), or leave it: the model allows"
        " for it.\n" in text
    )
    assert "\nFurther recordings: None beyond (1).\n" in text
    assert "\nFurther recordings: None beyond what is to do first.\n" in mail(
        replace(sound, effects=()), outcome
    )
    unsure = replace(sound, effects=(replace(play, grade="stands_in"),))
    assert "Look for the play" not in mail(unsure, outcome)


def test_what_only_fitted_recordings_demand_is_to_be_fitted_on_each_ground() -> None:
    diagnosis = make_diagnosis(("a", "b"), ("c",), unexplained=False)
    torsion, offset = diagnosis.effects
    weak = replace(offset, grade="weak", standard_errors=2.5, deviations=136.6)
    diagnosis = replace(diagnosis, effects=(replace(torsion, experiment=None), weak))
    text = mail(diagnosis, make_outcome("c", tracks=TRACKS[:2]))
    assert (
        "To do first: Fit a recording of each ground (with --holdout, leave that out), which settles"
        in text
    )
    assert "whether torque offset is there, as only the fitted recordings demand it" in text
    assert (
        " The model allows for torque offset, which the recordings that judge do not confirm. " in text
    )
    assert "chance" not in text
    assert "has a zero error: −0.12 N m (not confirmed)." in text


def test_what_nobody_declared_is_told_with_the_band_and_not_again() -> None:
    note = assumed_tolerances_note([SimpleNamespace(rig=Rig(a=0.04, e=0.0))])  # type: ignore[list-item]
    diagnosis = replace(make_diagnosis(), notes=(note, "c got worse"))

    assert band_caveats(diagnosis) == [
        "Assumed, as nobody declared a tolerance: half-length a ± 2 mm, caster e (kingpin to"
        " contact) ± 2 mm, load ± 2 %, tread stiffness k (how steeply the torque rises) ± 20 % of its"
        " fitted value. The ± of friction covers errors of this size, no larger ones."
    ]
    text = mail(diagnosis, make_outcome("c", tracks=TRACKS))
    assert band_caveats(diagnosis)[0] in text
    to_declare = next_steps(diagnosis, make_outcome("c", tracks=TRACKS))[-1]
    assert to_declare.startswith(
        "find out how well half-length a, caster e, load and tread stiffness k were measured (measure"
        " what was guessed), and declare the tolerances in the rig file"
    )
    assert notes_not_in_text(diagnosis, text) == ["c got worse"]
    assert notes_not_in_text(diagnosis, "") == [note, "c got worse"]
    assert band_caveats(make_diagnosis())[0].startswith("The ± of friction covers the tolerances")
    beyond = replace(diagnosis, notes=(f"{BEYOND_RANGE}, so", f"{MAY_END}: c"))
    assert band_caveats(beyond)[:2] == [
        f"{BEYOND_RANGE[:1].upper()}{BEYOND_RANGE[1:]}, so.",
        "The sensor may end: c.",
    ]


def test_friction_is_told_with_the_sliding_speed_that_it_belongs_to() -> None:
    known = make_outcome("c", tracks=TRACKS)
    text = mail(make_diagnosis(), replace(known, slide_speed=0.00182, slide_rate=0.1))
    assert "that of turning at 0.1 rad/s (5.7°/s, sliding 1.8 mm/s); not for" in text
    assert "that of turning" not in mail(make_diagnosis(), known)


def test_what_a_remedy_brings_is_what_its_parts_make_of_the_band() -> None:
    budget = {SLOPE: 0.08, OF_LENGTHS: 0.05, OF_LOAD: 0.0331662}
    tracks = [make_track(n, 1.2 + d, budget=budget) for n, d in SPREAD]
    outcome = make_outcome(tracks=tuple(tracks), grounds={"ice": ("a", "b", "c")})
    nothing = make_diagnosis(found=False, unexplained=False)
    # t of two degrees of freedom 4.3027, scatter 0.02; 64 % of the own variance of 0.05**2 goes.
    between, own = 4.3027 * 0.02 * np.sqrt(4 / 3), 1.96 * 0.05

    less = np.hypot(between, np.sqrt(0.36) * own)
    text = f"± {np.hypot(between, own):.2f} to ± {less:.2f} on ice at best"
    assert f"; that lowers {text}" in next_steps(nothing, outcome)[0]
    assert "The ± of a ground also covers how its recordings differ." in causes_of_band_text(outcome)
    two = replace(outcome, grounds={"ice": ("a", "b", "c"), "snow": ()})
    assert next_steps(nothing, two)[0].startswith(next_steps(nothing, outcome)[0].partition(";")[0])


def test_recordings_of_the_demo_are_told_as_simulated_wherever_they_are_read_from() -> None:
    source = demo_folder() / "train_a.csv"
    copied, own = Path("ours.csv"), Path("own.csv")
    copied.write_bytes(source.read_bytes())
    own.write_bytes(source.read_bytes() + b"\n")

    assert demo_recordings_warning(provenance_of([copied])).startswith(
        "Simulated, not measured: all rec"
    )
    (module := Path("own.py")).write_text("")
    assert "all recordings come" in demo_recordings_warning(provenance_of([copied, module]))
    assert "1 of 2 recordings come" in demo_recordings_warning(provenance_of([copied, own]))
    assert demo_recordings_warning(provenance_of([own])) == demo_recordings_warning(None) == ""
    text = mail(make_diagnosis(), make_outcome("c"), demo_recordings_warning(provenance_of([copied])))
    assert text.startswith("Note: Simulated, not measured")


def test_friction_is_provisional_where_k_says_that_the_torque_may_read_wrong() -> None:
    tracks = (*TRACKS[:2], make_track("c", 1.3))
    outcome = make_outcome("c", tracks=tracks, grounds={"ice": ("a", "b", "c")})
    note = (
        "the fitted stiffness k is 1·10⁶ N/m², 60 % above the declared one: if the torque reads too"
        " high, A; if the declared half-length of the contact is too short, B; if the tyre is so, C"
    )
    for ratio, ways in (
        (1.6, ("about 0.75 on ice", "not less than 1.03 on ice")),
        (0.5, ("about 2.40 on ice", "not more than 1.51 on ice")),
    ):
        diagnosis = replace(
            make_diagnosis(("a", "b"), ("c",)), stiffness_ratio=ratio, notes=(note, "other")
        )
        ((label, (told,)), (why, (*reasons,)), (how, (sure,)), *_), ((means, cases), *_) = (
            summary_mail_parts(diagnosis, outcome)
        )
        assert (label, why) == ("Do not use it yet", "Why")
        assert told.startswith("friction between tyre and ground 1.2"), "verdict and number"
        assert told.endswith(". The ± holds only if the rig proves right.")
        high = "high" if ratio > 1 else "low"
        assert reasons[0] == (
            f"The tyre comes out {ratio:.2f} times as stiff as declared; if the torque reads so much too"
            f" {high}, friction is {ways[0]}."
        )
        assert "Do not specify to it before the rig is checked, and before" in reasons[-1]
        # From the lower end over the ratio to the upper end: 1.20 with a band of 0.51.
        ends = "0.43 to 1.71" if ratio > 1 else "0.69 to 3.42"
        doubt = f"Whether the torque or k is off: friction is from {ends} on ice; other errors come"
        assert sure.startswith(doubt)
        assert (how, means) == ("How sure", "What the stiffness may mean")
        assert cases == [
            "The fitted stiffness k, how steeply the torque rises before anything slides, is 1·10⁶ N/m²,"
            " 60 % above the declared one; these recordings do not tell why.",
            f"If the torque reads too high, A: then {ways[0]}.",
            f"If the declared half-length of the contact is too short, B: then {ways[1]}.",
            "If the tyre is so, C.",
        ]
        assert notes_not_in_text(diagnosis, mail(diagnosis, outcome)) == ["other"], "told once"
    alone = replace(outcome, grounds={"": ("a", "b", "c")})
    unnamed = mail(diagnosis, alone)
    assert "reads too high, A. If the declared" in unnamed
    assert "cases, if model and tolerances are right, which is in doubt here." in unnamed
    assert "\nWhy: The tyre comes out 0.50" in unnamed
    other_ground = replace(tracks[0], name="d")
    two = replace(outcome, tracks=(*tracks, other_ground), grounds={**outcome.grounds, "snow": ("d",)})
    assert "friction is from 0.69 to 3.42 on ice;" in mail(diagnosis, two), "snow has no band"
    for ratio in (0.625, 1.6):
        car = replace(diagnosis, of_car=True, stiffness_ratio=np.float64(ratio))
        told = mail(car, outcome)
        assert told.startswith("Do not use it yet"), (
            "a force that reads too low looks like a soft column"
        )
        assert ("; if the force reads so much too high, friction is about" in told) == (ratio > 1)
        assert "Why: Tyres and what yields beside them come out" in told
        assert "before the car is checked" in told
        assert "only if the car proves right.\n" in told
    other = note.replace("1·10⁶", "2·10⁶")
    both = mail(replace(diagnosis, notes=(note, other)), outcome)
    assert (both.count("if the torque reads too"), both.count(": then ")) == (2, 0), "of which ground?"
    never = replace(outcome, tracks=tuple(replace(t, usable=np.zeros(11, dtype=bool)) for t in tracks))
    assert mail(diagnosis, never).count("he fitted stiffness k, how") == 1
    assert "How sure: The fitted stiffness k, how" in mail(diagnosis, never), "in the mail itself"
    nothing_found = replace(
        make_diagnosis(("a", "b"), ("c",), found=False, unexplained=False), notes=(note,)
    )
    beside = mail(replace(nothing_found, stiffness_ratio=1.6), outcome)
    assert "lacks nothing beside its stiffness that" in beside
    dotted = replace(outcome, grounds={"asphalt no. 2": ("a", "b", "c")})
    assert "asphalt no.\n" not in mail(replace(nothing_found, notes=()), dotted)
    wrong_input = replace(diagnosis, notes=(f"{SUSPECTED}: c", note))
    assert [step[:8] for step in next_steps(wrong_input, outcome)][:2] == ["mend the", "whoever "]
    assumed = replace(diagnosis, notes=(note, f"{ASSUMED}: load ± 2 %"))
    first, second, *_ = next_steps(assumed, outcome)
    assert (first[:16], second[:30]) == ("whoever keeps th", "at the rig, on the same visit,")
    both_wrong = replace(assumed, notes=(f"{SUSPECTED}: c", *assumed.notes))
    begun = [step[:8] for step in next_steps(both_wrong, outcome)]
    assert begun[:3] == ["mend the", "whoever ", "at the r"]
    sound = replace(diagnosis, stiffness_ratio=1.0)
    known = StiffnessComparison(found=2.158e6, declared=1.88e6, tolerance=0.376e6, assumed=True)
    assert (
        "\nStiffness: Found 2.16·10⁶ N/m², declared 1.88·10⁶, +15 %: inside its tolerance of ± 20 %"
        " (assumed, as none is declared).\n" in mail(replace(sound, notes=(), stiffness=known), outcome)
    )
    assert "inside its" not in mail(replace(diagnosis, stiffness=known), outcome)
    assert "Do not use" not in mail(replace(sound, notes=()), outcome)
    # Where no friction was estimated, what was found comes first.
    assert summary_mail_parts(sound, None)[0][0][0] == "What the assumed model leaves out"
    nothing = summary_mail_parts(make_diagnosis(found=False, unexplained=False), None)
    assert nothing[0][0][1][0].startswith("The assumed model lacks nothing that")


def test_what_measuring_brings_is_of_what_is_measured_and_of_its_ground() -> None:
    budgets = {"ice": {OF_LOAD: 0.01, OF_LENGTHS: 0.05}, "snow": {OF_LOAD: 0.05, OF_LENGTHS: 0.01}}
    names = {"ice": ("a", "b", "c"), "snow": ("d", "e", "f")}
    tracks = tuple(
        make_track(name, budget=budgets[ground]) for ground, own in names.items() for name in own
    )
    outcome = make_outcome(tracks=tracks, grounds=names)
    for value, brought in (
        (
            "load ± 2 %",
            "load was measured (measure what was guessed), and declare its tolerance in the rig file;"
            " that lowers ± 0.10 to",
        ),
        (
            "tread stiffness k ± 20 %",
            "tread stiffness k was measured (measure what was guessed), and declare its tolerance in the"
            " rig file; that hardly narrows the ±",
        ),
    ):
        diagnosis = replace(make_diagnosis(), notes=(f"{ASSUMED}: {value}",))
        last = next_steps(diagnosis, outcome)[-1]
        assert last.startswith(f"find out how well {brought}")
        assert ("on snow at best" in last, "on ice" in last) == (value.startswith("load"), False)
    small = tuple(replace(t, mu=0.05 * t.mu / t.mu, mu_std=np.full(11, 1e-4)) for t in tracks)
    spread = [replace(t, mu=t.mu + 0.001 * i) for i, t in enumerate(small)]
    steps = next_steps(make_diagnosis(), replace(outcome, tracks=tuple(spread)))
    assert any("± 0.005 would come to about ± 0.003 " in step for step in steps)


def test_the_weaker_direction_is_told_beside_the_mean_of_both() -> None:
    outcome = make_outcome("c", tracks=TRACKS[:2], grounds={"ice": ("a", "b")})
    diagnosis = make_diagnosis(("a", "b"), ("c",))
    assert "both directions" not in mail(diagnosis, outcome)
    model = Model(effects=effects_named(["asymmetric_friction"]))
    tyre = {"k": 2.4e6, "asymmetric_friction.ratio": 0.6}
    unlike = replace(diagnosis, model=model, values=replace(diagnosis.values, tyre=tyre))
    assert (
        "Friction is the mean of both directions of turning; by the model found it is 25 % less while"
        " the angle rises." in mail(unlike, outcome)
    )
    # On one page both figures are against the mean: 1 and 0.6 have 0.8.
    ratio = SimpleNamespace(value=0.6)
    known = replace(diagnosis.effects[0], name="asymmetric_friction", parameters={"ratio [1]": ratio})
    assert effect_summary(diagnosis, known).endswith(
        "lower while the angle rises than while it falls (25 % below the mean of both)"
    )
    odd = replace(diagnosis.effects[0], name="asymmetric_friction", grade="stands_in")
    told = mail(replace(unlike, effects=(odd,)), outcome)
    assert "while the angle rises (unproven)." in told


def test_how_well_recordings_repeat_is_told() -> None:
    groups = (("a", "b"), ("c", "d"))
    known = Repeatability(replicates=groups, spread=0.048, nrmse=0.013, spreads=(0.02, 0.07))
    diagnosis = replace(make_diagnosis(), repeatability=known)
    told = repeatability_in_words(diagnosis)
    assert told not in mail(diagnosis, make_outcome()), "of those who work on the model"

    assert (
        "in the torque at which the tyre slides (standard deviation): “a” and “b” by 2.00 %; “c” and “d”"
        " by 7.00 %. Up to" in told
    )
    assert "Up to 1.30 % of the torque's range may come from that" in told


def test_by_how_much_grounds_differ_is_told_or_that_they_may_be_one() -> None:
    """Means of 1.20 and 1.25, or 1.60, with standard deviations of 0.1 of three recordings each."""
    names = tuple("abcdef")
    diagnosis, grounds = make_diagnosis(names, ()), {"ice": names[3:], "snow": names[:3]}
    for middle, told in (
        (1.25, "Grounds: These recordings do not tell snow from ice: the difference may be chance."),
        # Welch's band of 1.6 over 1.2, of 3.7 degrees of freedom: 2.87 * 0.1 / sqrt(3) * 5 / 3 / 1.2.
        (
            1.6,
            "Grounds: Ice grips 1.33 ± 0.23 times as much as snow (in 95 of 100 cases; errors of"
            " lengths, load, torque and stiffness that both share cancel).",
        ),
    ):
        values = {"a": 1.1, "b": 1.2, "c": 1.3, "d": middle - 0.1, "e": middle, "f": middle + 0.1}
        tracks = tuple(make_track(n, mu) for n, mu in values.items())
        outcome = make_outcome(tracks=tracks, grounds=grounds)
        assert told in mail(diagnosis, outcome)
    heavy = tuple(replace(s, F_N=1.5 * s.F_N) if s.name in "def" else s for s in diagnosis.series)
    told = mail(replace(diagnosis, series=heavy), outcome)
    assert "times as much as snow, if it is not the load, which differs too (in 95" in told
    assert "Grounds:" not in mail(diagnosis, replace(outcome, grounds={"ice": names}))
    many = {f"g{i}": tuple(f"{i}{n}" for n in "abc") for i in range(4)}
    tracks = tuple(
        make_track(name, 0.3 + 0.2 * i + 0.001 * j)
        for i, own in enumerate(many.values())
        for j, name in enumerate(own)
    )
    told = mail(diagnosis, make_outcome(tracks=tracks, grounds=many))
    assert told.count("times as much as g0") == told.count("times as much as") == 3


def test_the_load_that_friction_is_told_at_stands_beside_it() -> None:
    outcome = make_outcome(tracks=TRACKS, grounds={"ice": ("a", "b", "c", "d")})
    diagnosis = make_diagnosis(("a", "b", "c", "d"), ())
    told, silent = replace(outcome, load=589.4), outcome
    table = friction_by_recording(told, diagnosis)

    assert table.headings[3] == "μ_eff at a load of 589 N"
    assert "all converted to a load of 589 N, as friction changes with it" in table.caption
    assert "all converted to a load of 589 N, as friction changes with it." in mail(diagnosis, told)
    assert friction_and_notes(told)[1][0].startswith("note on ice at a load of 589 N: ")
    assert told.to_dict()["after"]["load"] == 589.4
    assert "at a load of 589" not in mail(diagnosis, silent)
    assert friction_by_recording(silent, diagnosis).headings[3] == "μ_eff"
