"""Parameters by nonlinear programming: bounded least squares on the free-run torque, exact Jacobians.

Every recording is simulated from its first sample to its last (never one step ahead). All recordings
share the rig's parameters, those on one ground what belongs to that; mu and whatever else belongs to a
recording is each one's own. Residuals are divided by the range of the recording's torque, so that each
recording counts alike.

What was declared with a tolerance is a parameter of its recording. It may lie anywhere within the
tolerance; in the cost stands the normal density of the same variance. Samples of a residual of standard
deviation sigma that lasts over T samples are worth one in T, so the squared distance from the declared
value counts sigma^2 T in the sum of squares over samples.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from scipy.linalg.lapack import dgeqrf
from scipy.optimize import OptimizeResult, least_squares

from identification.fits.least_squares_problem import LeastSquaresProblem, shares_of_torque_range
from identification.fits.loss import LEAST_SQUARES, Loss, cost
from identification.fits.options import FINE_FIT, FitOptions, OwnerAndName
from identification.fits.single_threaded_blas import one_thread
from identification.fits.values_by_ground_and_recording import Values, complete_values, initial_guess
from identification.reading.declared_sensor_range import drop_torques_beyond_range
from identification.reading.recordings import Recording
from symbolic import Model, parameter_name
from symbolic.float_array_type import Array

SAME_WEIGHT = 0.3
"""Relative change of such a weight that counts as none [1]."""
FIXING_WEIGHT = 100.0
"""Weight that fixes the declared values in the first of two solves [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A solved identification.

    Attributes:
        model: the model fitted.
        values: the parameters at the solution.
        residuals: for each recording, simulated minus measured torque [N m], NaN where missing.
        jacobian: of the stacked residuals over torque range, in scaled coordinates, rows of missing
            samples left out; the loss does not enter it.
        labels: owner and parameter of each Jacobian column.
        scales: size of a unit step of each column, in the parameter's coordinate.
        bound_distances: unit steps down (<= 0) and up (>= 0) to the bounds of each, shape (2, p).
        status: the solver's message at its end.
        converged: False where the solver stopped for another reason than its tolerances.
        loss: cost of a residual.
        prior_weights: residual over range that a unit step of each column away from its declared value
            counts as, 0 for what was declared without a tolerance, shape (p,).
        prior_steps: unit steps from the declared value, 0 for such, shape (p,).
    """

    model: Model
    values: Values
    residuals: Mapping[str, Array]
    jacobian: Array
    labels: tuple[OwnerAndName, ...]
    scales: Array
    bound_distances: Array
    status: str
    converged: bool
    loss: Loss = LEAST_SQUARES
    prior_weights: Array
    prior_steps: Array

    @property
    def recording_columns(self) -> tuple[bool, ...]:
        """For each column, whether it belongs to a recording, not to the tyre or a ground."""
        return tuple(owner in self.residuals for owner, _ in self.labels)

    @property
    def prior_weights_of_recordings(self) -> dict[str, float]:
        """`prior_weights` by recording, of those that have such values [1]."""
        pairs = zip(self.labels, self.prior_weights, strict=True)
        return {owner: float(weight) for (owner, _), weight in pairs if owner and weight > 0}

    def cost(self, recordings: Sequence[Recording]) -> float:
        """Loss summed over the samples of these recordings, which must be among those fitted [1]."""
        shares = shares_of_torque_range(self.residuals, recordings)
        return sum(cost(self.loss, share) for share in shares.values())


@one_thread
def fit(
    model: Model,
    recordings: Sequence[Recording],
    start: Values | None = None,
    options: FitOptions = FINE_FIT,
) -> Fit:
    """Find the parameters of least loss over all recordings.

    Torques beyond the declared range of their sensor are left out. Names of recordings must differ. The
    start is that of `initial_guess` for None; a value that is missing begins at its parameter's start.

    Raises:
        InvalidInputError: a torque is constant, or no parameter is free.
    """
    recordings = [drop_torques_beyond_range(recording) for recording in recordings]
    begin = start or initial_guess(model, recordings)
    problem = LeastSquaresProblem(model, recordings, complete_values(model, begin, recordings), options)
    x = problem.start_coordinates()
    if not options.prior_weights:
        weights = problem.prior_weights(np.clip(x, *problem.bounds()))
    else:
        mean = float(np.mean(list(options.prior_weights.values())))
        given = [options.prior_weights.get(owner or "", mean) for owner, _ in problem.labels]
        weights = np.where(problem.has_prior, given, 0.0)
        if options.free_shared and not begin.rig and weights.any():
            # Lengths that give way at once hold the fit at a minimum of its own.
            x = _solve(problem, x, np.where(weights > 0, FIXING_WEIGHT, 0.0), options).x
    solution = _solve(problem, x, weights, options)
    for _ in range(options.reweightings):
        revised = problem.prior_weights(solution.x)
        if np.allclose(revised, weights, rtol=SAME_WEIGHT, atol=0.0):
            break
        weights = revised
        solution = _solve(problem, solution.x, weights, options)
    return Fit(
        model=model,
        values=problem.values(solution.x),
        residuals=problem.torque_errors(solution.x),
        # The solver's own is weighted by the loss.
        jacobian=problem.jacobian(solution.x),
        labels=tuple(problem.labels),
        scales=problem.scales,
        bound_distances=np.array(problem.bounds()) - solution.x,
        status=str(solution.message),
        converged=solution.status > 0,
        loss=options.loss,
        prior_weights=weights,
        prior_steps=np.where(weights > 0, solution.x - problem.declared, 0.0),
    )


def _solve(
    problem: LeastSquaresProblem, start: Array, weights: Array, options: FitOptions
) -> OptimizeResult:
    """Least loss of the torque with least squares of what was declared with a tolerance."""
    low, high = problem.bounds()
    known = weights > 0
    rows = np.diag(weights)[known]
    loss: Loss = options.loss

    def residuals(x: Array) -> Array:
        return np.concatenate([problem.residuals(x), rows @ (x - problem.declared)])

    def jacobian(x: Array) -> Array:
        return np.concatenate([problem.jacobian(x), rows])

    def rho(squares: Array) -> Array:
        count = squares.size - int(known.sum())
        return np.hstack([loss(squares[:count]), LEAST_SQUARES(squares[count:])])

    @lru_cache(maxsize=1)
    def triangle(x: bytes) -> Array:
        at = np.frombuffer(x)
        errors, slopes = residuals(at), problem.jacobian(at)
        stacked = np.empty((errors.size, at.size + 1), order="F")
        stacked[: len(slopes), :-1], stacked[len(slopes) :, :-1], stacked[:, -1] = slopes, rows, errors
        # In place; numpy.linalg.qr takes four times as long.
        return np.asarray(np.triu(dgeqrf(stacked, overwrite_a=True)[0][: min(stacked.shape)]))

    solve = partial(
        least_squares,
        x0=np.clip(start, low, high),
        bounds=(low, high),
        x_scale=1.0,
        ftol=options.tolerance,
        xtol=options.tolerance,
        gtol=1e-12,
        max_nfev=options.max_evaluations,
    )
    if loss == LEAST_SQUARES:
        # The same squares in no more rows than columns, on which the solver is quick.
        return solve(lambda x: triangle(x.tobytes())[:, -1], jac=lambda x: triangle(x.tobytes())[:, :-1])
    return solve(residuals, jac=jacobian, loss=rho)


AT_BOUND = 1e-3
"""A parameter is at a bound within this share of its scale [1]."""


def parameters_at_bounds(fitted: Fit) -> Iterator[tuple[str, str, str]]:
    """Shared parameters that end where their range does: effect, name, and the same in words."""
    named = {parameter_name(effect, p): (effect, p) for effect, p in fitted.model.parameters if effect}
    for (owner, name), own in zip(fitted.labels, fitted.recording_columns, strict=True):
        if own or name not in named:
            continue
        effect, parameter = named[name]
        value, ground = fitted.values.at((owner, name)), f" on {owner}" if owner else ""
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        for end in (parameter.lower, parameter.upper):
            if end != parameter.neutral and abs(value - end) <= AT_BOUND * parameter.scale:
                words = f"{parameter.name}{ground} is at the end of its range, {end:g}{unit}"
                yield effect.name, parameter.name, words


def last_effect_at_bound(fitted: Fit) -> bool:
    """Whether a shared parameter of the last effect is at the end of its range."""
    last = fitted.model.effects[-1].name if fitted.model.effects else None
    return any(effect == last for effect, *_ in parameters_at_bounds(fitted))
