"""The order of trials and decisions of the search, on errors made up for every set of effects."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from identification.fits.values_by_ground_and_recording import Values
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from identification.selection.search_step import (
    SearchStep,
    begin_trials_without_each,
    rank_for_confirmation,
)
from identification.selection.stepwise_search import Search
from identification.selection.trial import FINE, RANKING, ROUGH, Precision, Trial
from identification.selection.trial_runner import Effects, TrialRunner, ignore_progress
from tests.identification.selection.compared import (
    SECONDS,
    Pair,
    compared_by,
    effect_of,
    judgement,
    trials,
    with_effects,
)


class Scripted:
    """A runner whose trials have made-up errors: a letter is an effect, its parameters one each.

    Attributes:
        asked: sets of effects that were ranked, call by call.
        fitted: sets of effects that were fitted to the whole recordings.
        discretised: whether the last of these had bristles whatever its effects are.
        precisions: of the coarse trials.
        white: sets of effects whose trials leave white noise; others leave a correlated residual.
    """

    white: tuple[str, ...] = ()

    def __init__(  # noqa: D107
        self, pair: Pair, coarse: Callable[[str], float], fine: Callable[[str], float] | None = None
    ) -> None:
        self.pair, self.coarse, self.fine = pair, coarse, fine or coarse
        self.asked: list[list[str]] = []
        self.fitted: list[str] = []
        self.precisions: list[Precision] = []
        self.training = self.thinned_training = pair[1][:1]

    def trial(self, names: str, error: float) -> Trial:
        """A trial of this error; its training residual is so much smaller that parameters pay off."""
        trial, (training, _) = self.pair
        noise = np.random.default_rng(3).standard_normal(training.t.size)
        if names not in self.white:
            noise = np.convolve(noise, np.ones(3) / np.sqrt(3), mode="same")
        labels = tuple((None, str(i)) for i in range(4 + len(names)))
        values = Values(tyre=dict.fromkeys((f"{name}.value" for name in names), 1.0), own={})
        residuals = {training.name: error * noise}
        weights = np.zeros(len(labels))
        fitted = replace(
            trial.fitted, residuals=residuals, labels=labels, values=values, prior_weights=weights
        )
        made = with_effects(replace(trial, fitted=fitted), names)
        return replace(made, judgement=judgement(np.full(SECONDS, error)))

    def run_on_whole_recordings(
        self, effects: Effects, start: Values | None = None, precision: Precision = FINE
    ) -> Trial:
        self.fitted.append(letters(effects))
        self.discretised = precision.discretised
        unknown = [name for name in start.tyre if name[0] not in self.fitted[-1]] if start else []
        assert not unknown, "a fit refuses values of effects that its model does not have"
        return self.trial(self.fitted[-1], self.fine(self.fitted[-1]))

    def begin_on_whole_recordings(
        self, starts: Mapping[str, tuple[Effects, Values]], precision: Precision
    ) -> Callable[[], dict[str, Trial]]:
        return lambda: {
            key: self.run_on_whole_recordings(*start, precision) for key, start in starts.items()
        }

    def run_on_thinned_recordings(self, effects: Effects, _: Values, precision: Precision) -> Trial:
        self.precisions.append(precision)
        return self.trial(letters(effects), self.coarse(letters(effects)))

    def rank(
        self, _: Trial, sets: Sequence[Effects], precision: Precision, report: Callable[[int], None]
    ) -> list[Trial]:
        self.precisions.append(precision)
        report(len(sets))
        self.asked.append([letters(effects) for effects in sets])
        made = [self.trial(names, self.coarse(names)) for names in self.asked[-1]]
        return sorted(made, key=lambda trial: trial.nrmse)


def letters(effects: Effects) -> str:
    return "".join(effect.name for effect in effects)


def searched(
    runner: Scripted, candidates: str, criteria: SelectionCriteria = DEFAULT_CRITERIA
) -> list[SearchStep]:
    effects = tuple(effect_of(name) for name in candidates)
    return Search(cast(TrialRunner, runner), effects, criteria, ignore_progress).run()


def path(steps: Sequence[SearchStep]) -> list[str]:
    """The effects after each step but the last."""
    return ["".join(step.after.names) for step in steps if step.after]


def table(**errors: float) -> Callable[[str], float]:
    """Errors in percent by effects in any order; 10 for those that are not there."""
    by_set = {"".join(sorted(names)).replace("_", ""): error for names, error in errors.items()}
    return lambda names: by_set.get("".join(sorted(names)), 10.0) / 100


def test_adds_what_helps_most_until_nothing_helps(pair: Pair) -> None:
    runner = Scripted(pair, table(a=8, b=5, ab=3, bc=4, abc=2.97))
    steps = searched(runner, "abc")

    assert path(steps) == ["b", "ba"]
    assert runner.asked[:3] == [["a", "b", "c"], ["ba", "bc"], ["bac"]]
    assert [trial.names for trial in steps[0].trials] == [("b",), ("a",), ("c",)]
    assert steps[-1].after is None


@pytest.mark.parametrize(("bad", "expected"), [("", "a"), ("a", "b"), ("ab", "c"), ("abc", None)])
def test_the_next_best_is_tried_where_the_best_fails(pair: Pair, bad: str, expected: str | None) -> None:
    """What was ranked coarsely is fitted to the whole recordings, three candidates at most."""
    errors = table(a=5, b=6, c=7, d=8)
    runner = Scripted(pair, errors, lambda names: 0.1 if set(names) & set(bad) else errors(names))
    steps = searched(runner, "abcd")

    assert (path(steps) or [None])[0] == expected
    tried = list("abc" if expected is None else "abcd"[: len(bad) + 1])
    assert runner.fitted[: len(tried) + 1] == ["", *tried]


@pytest.mark.parametrize(
    ("with_both", "expected"), [(4.0, ["s", "st"]), (4.4, ["s"])], ids=["much more", "a wrong law's"]
)
def test_a_second_law_of_a_family_has_to_explain_much_more(
    pair: Pair, with_both: float, expected: list[str]
) -> None:
    """The first explains 100 - 25; a second that explains less than 0.3^2 of it is no finding."""
    assert path(searched(Scripted(pair, table(s=5, t=6, st=with_both)), "st")) == expected


@pytest.mark.parametrize(("first", "second"), ["sz", "zs"])
def test_a_zero_of_each_recording_is_no_second_law(pair: Pair, first: str, second: str) -> None:
    """No wrong law of its family leaves what a zero explains, and no zero leaves a law."""
    errors = table(**{first: 5, second: 6, first + second: 4.4})
    assert path(searched(Scripted(pair, errors), "sz")) == [first, first + second]


@pytest.mark.parametrize(
    ("errors", "expected"),
    [({"a": 3, "ab": 2.6}, "ab"), ({"a": 3, "ab": 2.7}, "a"), ({"a": 8, "ab": 7.65}, "a")],
    ids=["more than a wrong law leaves", "less", "less than 5 %"],
)
def test_a_further_effect_has_to_explain_more_than_a_wrong_law(
    pair: Pair, errors: dict[str, float], expected: str
) -> None:
    """The first explains 100 - 9, of which 0.15^2 are 2.05: the error has to fall below 2.636."""
    assert path(searched(Scripted(pair, table(**errors)), "ab"))[-1] == expected


@pytest.mark.parametrize("effects", ["ab", "st"])
def test_what_another_effect_explains_to_the_noise_is_no_wrong_laws_remainder(
    pair: Pair, effects: str
) -> None:
    """Unless the first leaves hardly more than noise, which many an effect matches."""
    for error, white, expected in ((1.7, "", 1), (1.7, effects, 2), (1.8, effects, 1)):
        runner = Scripted(pair, table(**{effects[0]: 2, effects: error}))
        runner.white = (white,)
        assert path(searched(runner, effects)) == [effects[0], effects][:expected]


def test_each_effect_is_taken_out_of_the_model_found(pair: Pair) -> None:
    """A model that was a step on the way is not fitted again."""
    runner = Scripted(pair, table(a=8, b=5, ab=3, bc=4, abc=2))
    steps = searched(runner, "abc")
    fitted = len(runner.fitted)

    rests = begin_trials_without_each(steps, cast(TrialRunner, runner))()

    assert {effect.name: letters(rest.effects) for effect, rest in rests.items()} == {
        "b": "ac", "a": "bc", "c": "ba",
    }  # fmt: skip
    assert runner.fitted[fitted:] == ["ac", "bc"]
    assert runner.discretised is not steps[-1].before.fitted.model.uses_exact_patch


def test_a_flexible_law_takes_the_place_of_its_family(pair: Pair) -> None:
    errors = table(s=4, f=5, sa=3, fa=2, sfa=1.9)
    assert path(searched(Scripted(pair, errors), "sfa")) == ["s", "sa", "af"]


def test_of_equals_a_second_law_of_a_family_comes_last(pair: Pair) -> None:
    second, other = both(pair, 0, 1.5, ("sf", "st"))
    first = with_effects(second, "f")
    for flexible, leader in ((first, "f"), (second, "st")):
        best, *_ = rank_for_confirmation([flexible, other], compared_by(pair))
        assert "".join(best.trial.names) == leader


def test_no_exchange_makes_a_second_law_of_a_family(pair: Pair) -> None:
    """Beside s, t explains too little as its second law; in place of a it would be one all the same."""
    runner = Scripted(pair, table(s=5, a=8, sa=4.4, st=4.29, sat=4.25))
    assert path(searched(runner, "sat")) == ["s", "sa"]
    assert not any("st" in sets for sets in runner.asked[2:])


@pytest.mark.parametrize(("member", "expected"), [(2.01, "as"), (2.1, "fa")])
def test_a_flexible_law_gives_way_to_one_as_good(pair: Pair, member: float, expected: str) -> None:
    errors = table(f=4, s=5, fa=2, sa=member)
    assert path(searched(Scripted(pair, errors), "sfa"))[-1] == expected


def test_idle_candidates_are_tried_last(pair: Pair) -> None:
    """Next to no gain in two steps; in the third it is tried only as nothing else helps."""
    errors = table(a=9, b=8, c=9.95, d=9.85, ab=6, bc=7.95, bd=7.88, abc=5.95, abd=5.91)
    runner = Scripted(pair, errors)
    steps = searched(runner, "abcd", replace(DEFAULT_CRITERIA, exchanges=0))

    assert path(steps) == ["b", "ba"]
    # c gains 0.5 % twice, d gains 1.5 %: above half of the 2 % that are needed.
    assert runner.asked[:4] == [["a", "b", "c", "d"], ["ba", "bc", "bd"], ["bad"], ["bac"]]


def test_an_idle_law_is_a_rival_of_the_law_of_its_family_that_is_added(pair: Pair) -> None:
    """Law t gains nothing in two steps; in the third it does as well as s, a law of the same family."""
    errors = table(a=9, b=8, s=9.85, t=9.95, ab=6, bs=7.88, bt=7.95, abs=4, abt=3.99)
    steps = searched(Scripted(pair, errors), "abst", replace(DEFAULT_CRITERIA, exchanges=0))

    assert path(steps) == ["b", "ba", "bat"]
    assert letters(steps[2].indistinguishable) == "s"
    of_none = table(a=9, b=8, s=9.85, c=9.95, ab=6, bs=7.88, bc=7.95, abs=4, abc=3.99)
    steps = searched(Scripted(pair, of_none), "absc", replace(DEFAULT_CRITERIA, exchanges=0))
    assert {*path(steps)[2], *letters(steps[2].indistinguishable)} == {*"absc"}


def test_an_effect_that_the_others_replace_is_removed_and_stays_away(pair: Pair) -> None:
    runner = Scripted(pair, table(a=7, b=8, c=8, ab=5, ac=6, bc=3.005, abc=3))
    steps = searched(runner, "abc")

    assert path(steps)[:4] == ["a", "ab", "abc", "bc"]
    assert [step.removed_effect.name for step in steps if step.removed_effect] == ["a"]
    backward = runner.asked[3]
    assert backward == ["bc", "ac"], "not without the effect that was added last"
    asked_after = [names for names in runner.asked[4:] if names]
    assert not any("a" in names for sets in asked_after for names in sets)


def test_three_candidates_at_most_are_exchanged_and_only_helpful_ones(pair: Pair) -> None:
    # Adding gains enough by coarse trials, but is not confirmed by fine ones.
    coarse = table(a=5, ab=4.8, ac=4.85, ad=4.87, ae=4.88, af=4.95, b=9, c=9, d=9, e=9, f=9)
    fine = table(a=5)
    runner = Scripted(pair, coarse, fine)
    steps = searched(runner, "abcdef")

    assert path(steps) == ["a"]
    assert ["b", "c", "d"] in runner.asked
    few = Scripted(pair, table(a=5, ab=4.8, ac=4.95), fine)
    searched(few, "abc")
    assert ["b"] in few.asked


def test_an_exchange_has_to_lower_the_error(pair: Pair) -> None:
    coarse = table(a=5, b=5.5, c=6, ab=4.8, ac=4.7)
    runner = Scripted(pair, coarse, table(a=5, b=4, c=4.5))
    steps = searched(runner, "abc")

    assert path(steps) == ["a"], "better on the whole recordings, but not where they were ranked"
    assert [trial.names for trial in steps[-1].trials] == [("a", "c"), ("a", "b")]

    runner = Scripted(pair, table(a=5, b=5.5, ab=4.8), table(a=5, b=4))
    assert path(searched(runner, "ab")) == ["a"]


def test_an_exchange_is_a_step(pair: Pair) -> None:
    errors = table(a=5, b=6, c=6, ab=4, ac=4.5, bc=3, abc=3.9)
    runner = Scripted(pair, errors, table(a=5, b=6, c=6, ab=4, ac=4.5, bc=3))
    steps = searched(runner, "abc")

    assert path(steps)[:3] == ["a", "ab", "bc"]
    assert [step.removed_effect.name for step in steps if step.removed_effect] == ["a"]


def test_the_rival_of_the_last_effect_is_tried_where_nothing_can_be_added(pair: Pair) -> None:
    """Nothing helps beside a, c helps beside b, which did as well as a."""
    errors = table(a=5, b=5.05, c=8, ab=4.95, ac=4.95, bc=4)
    runner = Scripted(pair, errors)
    steps = searched(runner, "abc")

    assert path(steps) == ["a", "b", "bc"]
    assert [step.removed_effect.name for step in steps if step.removed_effect] == ["a"]
    assert ["bc"] in runner.asked, "a itself is not tried beside its rival"

    runner = Scripted(pair, table(a=5, b=5.05, c=8, ab=4.95, ac=4.95, bc=4.93))
    assert path(searched(runner, "abc")) == ["a"], "the pair is no better either"
    runner = Scripted(pair, table(a=5, b=5.2, c=8, ab=4.95, ac=4.95, bc=4))
    assert path(searched(runner, "abc")) == ["a"], "b did not do as well"


def added(pair: Pair, names: str, rivals: str, trials: tuple[Trial, ...]) -> SearchStep:
    """A step to these effects, which the rivals equal."""
    equals, before = tuple(map(effect_of, rivals)), {"before": pair[0], "coarse_before": pair[0]}
    after = with_effects(pair[0], names)
    return SearchStep(**before, trials=trials, after=after, indistinguishable=equals)


def test_a_rival_with_more_parameters_is_not_tried(pair: Pair) -> None:
    step = added(pair, "b", "a", both(pair, 0.0, 1.5))

    assert step.equally_simple_rival is None, "a has one more"
    others = replace(step, after=with_effects(pair[0], "a"), indistinguishable=(effect_of("b"),))
    assert others.equally_simple_rival == effect_of("b")
    assert replace(step, after=None).equally_simple_rival is None


@pytest.mark.parametrize(
    ("error", "expected"), [(0.9, RANKING), (0.95, RANKING), (1.1, ROUGH), (1.4, ROUGH)]
)
def test_large_errors_are_ranked_by_few_bristles(pair: Pair, error: float, expected: Precision) -> None:
    runner = Scripted(pair, lambda _: error / 100)
    searched(runner, "a")

    assert set(runner.precisions) == {expected}


def both(pair: Pair, bic: float, error: float, names: Sequence[str] = "ab") -> tuple[Trial, Trial]:
    """Trials of these names, the first with one more parameter, see `trials`."""
    first, second = trials(pair, bic, error)
    return with_effects(first, names[0]), with_effects(second, names[1])


@pytest.mark.parametrize("distinguishable", [True, False])
def test_of_equals_the_one_with_the_fewest_parameters_goes_on(pair: Pair, distinguishable: bool) -> None:
    dearer, other = both(pair, 0.0, 2.5 if distinguishable else 1.5)
    ranked = rank_for_confirmation([dearer, other], compared_by(pair))
    expected = [(other, (effect_of("a"),)), (dearer, ())]
    if distinguishable:
        expected = [(dearer, ()), (other, ())]

    assert [(candidate.trial, candidate.indistinguishable) for candidate in ranked] == expected


def test_one_that_is_fitted_to_the_judging_recordings_does_not_go_on(pair: Pair) -> None:
    """Its judged error is far lower, but what it fits to each recording costs more than it gains."""
    training = pair[1][:1]
    # Of the tyre, nothing of the parameter is fitted to the recordings that judge.
    for bic, owner, expected in (
        (1.0, training[0].name, "b"), (-1.0, training[0].name, "a"), (1.0, None, "a"), (-1.0, None, "a"),
    ):  # fmt: skip
        best, other = both(pair, bic, 9.0)
        labels = (*other.fitted.labels, (owner, "more"))
        best = replace(best, fitted=replace(best.fitted, labels=labels))
        (first, *_) = rank_for_confirmation([best, other], compared_by(pair))
        assert first.trial.names == (expected,)


def test_a_difference_of_no_worth_does_not_distinguish(pair: Pair) -> None:
    """Every block has a lower error, but by one per cent only; then by three."""
    best, other = both(pair, 0.0, 2.5)
    sizes = 0.05 * (1 + 0.01 * np.random.default_rng(2).standard_normal(SECONDS))
    for factor, alike in ((1.01, True), (1.03, False)):
        one = replace(best, judgement=judgement(sizes))
        two = replace(other, judgement=judgement(factor * sizes))
        (first, *_) = rank_for_confirmation([one, two], compared_by(pair))
        assert bool(first.indistinguishable) == alike


def test_the_nearest_rival_is_the_best_of_those_that_are_as_good(pair: Pair) -> None:
    step = added(pair, "a", "dc", tuple(with_effects(pair[0], name) for name in "abcd"))

    assert step.nearest_rival == effect_of("c")


class Disputed(Scripted):
    """The fitted recordings demand effect a, those that judge reject it alone. d halves all errors."""

    def __init__(self, pair: Pair, together: float) -> None:  # noqa: D107
        def judged(names: str) -> float:
            error = together if {"a", "b"} <= {*names} else 0.045 if "a" in names else 0.04
            return error / (1 + ("d" in names))

        super().__init__(pair, judged)

    def trial(self, names: str, error: float) -> Trial:
        fitted = 0.01 if {"a", "b"} <= {*names} else 0.03 if "a" in names else 0.04
        trial = super().trial(names, fitted / (1 + ("d" in names)))
        return replace(trial, judgement=judgement(np.full(SECONDS, error)))


def test_an_effect_that_is_demanded_but_rejected_gets_a_partner(pair: Pair) -> None:
    runner = Disputed(pair, 0.01)
    steps = searched(runner, "abc")

    assert ["ab", "ac"] in runner.asked, "b and c are demanded by nothing: no pair of them is tried"
    assert steps[0].after is None
    assert path(steps) == ["ba", "ab"]
    # Each is graded by what it gains beside the other.
    assert [letters(step.before.effects) for step in steps[1:3]] == ["b", "a"]
    assert letters(steps[-1].before.effects) == "ab"


def test_a_pair_is_sought_beside_what_was_found_too(pair: Pair) -> None:
    runner = Disputed(pair, 0.01)
    steps = searched(runner, "abcd")

    assert ["dab", "dac"] in runner.asked
    assert path(steps) == ["d", "dba", "dab"]
    assert [letters(step.before.effects) for step in steps[1:4]] == ["d", "db", "da"]
    assert letters(steps[-1].before.effects) == "dab"


def test_a_pair_that_the_judges_reject_is_none(pair: Pair) -> None:
    runner = Disputed(pair, 0.0399)
    (step,) = searched(runner, "abc")

    assert step.after is None
    assert ["ab", "ac"] in runner.asked


def test_what_nothing_demands_gets_no_partner(pair: Pair) -> None:
    runner = Scripted(pair, lambda names: 0.01 if {"a", "b"} <= {*names} else 0.04)
    searched(runner, "abc")

    assert runner.asked == [["a", "b", "c"]]
