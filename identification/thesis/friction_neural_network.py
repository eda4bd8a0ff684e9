"""Friction from single samples by a neural network, [Györök 2022], sections 4.1 and 4.2.

The inputs of the network are the signals of one sample. Its output is mu, or the error of an analytic
estimate n(p), mu = n(p) + U(p, q), [Györök 2022], (4.9), called scientific machine learning there. Both
are trained on recordings with a declared mu and reproduce these labels; `LabelMean`, which has no input,
is the baseline that they have to beat.

The networks are scikit-learn's, an extra of this package: `pip install 'brushgrip[networks]'`.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from identification.reading.recordings import Recording
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

Inputs = Callable[[Recording], Array]
"""Inputs of a network over a recording, a row for each sample: shape (n, inputs), finite."""
MIN_LABELLED_SAMPLES = 100
"""Least number of labelled samples of a training."""


class Activation(StrEnum):
    """Activations of the hidden layers, [Györök 2022], (4.3) to (4.5), by scikit-learn's names."""

    RELU = "relu"
    SIGMOID = "logistic"
    TANH = "tanh"


@dataclass(frozen=True, kw_only=True)
class NetworkDesign:
    """A network and its training; the defaults are those of [Györök 2022] except for the layers."""

    # Neurons of each hidden layer. [Györök 2022] has (1024, 512), and (2048, 1024) on top of the
    # analytic estimate; these do no worse on its tests and train in a second.
    hidden: tuple[int, ...] = (64, 32)
    activation: Activation = Activation.SIGMOID  # Of the hidden layers; the output has none.
    epochs: int = 30  # Passes over the samples; the weights that did best on `held_back` are kept.
    batch: int = 32  # Samples a step of Adam.
    rate: float = 1e-3  # Learning rate of Adam.
    # Share of the samples that validates the passes and is not trained on; where all labels are the
    # same, the first pass is kept.
    held_back: float = 0.1
    seed: int = 0  # Of the first weights, the shuffling and the split.


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionNetwork:
    """A trained network as an estimator of mu over a recording."""

    name: str  # What tables call it.
    inputs: Inputs  # Its inputs over a recording.
    base: int | None  # Column of the inputs to which its output is added; None where its output is mu.
    regressor: Any  # Scikit-learn's pipeline, inputs -> output.
    losses: Array  # Half the mean square error over the labels' variance, after every pass.
    works_beyond_five_zones: bool  # Whether it does not assume five zones at most.
    gives_deviation: bool = False  # Whether it gives a standard deviation.

    def estimate_mu_eff(self, recording: Recording) -> Array:
        """Friction at every sample, shape (n,) [1]."""
        return self.predict_friction(self.inputs(recording))

    def predict_friction(self, rows: Array) -> Array:
        """Friction for any rows of inputs, shape (n,) [1]."""
        output = np.asarray(self.regressor.predict(rows), dtype=float)
        return output if self.base is None else output + rows[:, self.base]


@dataclass(frozen=True, kw_only=True)
class LabelMean:
    """The mean of the training labels, whatever is measured: the baseline of every method."""

    mu: float  # That mean [1]; the others are as of `FrictionNetwork`.
    name: str = "mean of the labels"
    works_beyond_five_zones: bool = True
    gives_deviation: bool = False

    def estimate_mu_eff(self, recording: Recording) -> Array:
        """The same at every sample, shape (n,) [1]."""
        return np.full(recording.t.size, self.mu)


def label_mean(recordings: Sequence[Recording]) -> LabelMean:
    """The mean label over all samples of these recordings."""
    return LabelMean(mu=float(np.concatenate([_labels(one) for one in recordings]).mean()))


def train_network(
    recordings: Sequence[Recording],
    inputs: Inputs,
    design: NetworkDesign | None = None,
    *,
    base: int | None = None,
    name: str = "neural network",
) -> FrictionNetwork:
    """Train a network on recordings whose mu is declared.

    Inputs and output are scaled to variance one over the training samples, which [Györök 2022] does
    not do; without it the angle, the load and k of table 3.1 differ by seven powers of ten. `base` is a
    column of the inputs, an estimate of mu, to which the output is added.

    Raises:
        InvalidInputError: scikit-learn is missing, a recording declares no mu, or there is too little.
    """
    design = design or NetworkDesign()
    rows = np.vstack([inputs(one) for one in recordings])
    target = np.concatenate([_labels(one) for one in recordings])
    if len(target) < MIN_LABELLED_SAMPLES:
        raise InvalidInputError(
            f"a network needs at least {MIN_LABELLED_SAMPLES} samples, got {len(target)}"
        )
    if base is not None:
        target = target - rows[:, base]
    regressor = _regressor(design)
    with warnings.catch_warnings():
        # Ending after so many epochs is what was asked for.
        warnings.filterwarnings("ignore", message="Stochastic Optimizer: Maximum iterations")
        regressor.fit(rows, target)
    return FrictionNetwork(
        name=name,
        inputs=inputs,
        base=base,
        regressor=regressor,
        losses=np.array(regressor.regressor_[-1].loss_curve_),
        works_beyond_five_zones=base is None,
    )


def _labels(recording: Recording) -> Array:
    if recording.tyre.mu is None:
        raise InvalidInputError(f"{recording.name}: declares no mu; a training needs one")
    return np.full(recording.t.size, recording.tyre.mu)


def _regressor(design: NetworkDesign) -> Any:
    try:
        from sklearn.compose import TransformedTargetRegressor
        from sklearn.neural_network import MLPRegressor
        from sklearn.pipeline import make_pipeline
        from sklearn.preprocessing import StandardScaler
    except ImportError:
        raise InvalidInputError(
            "networks need scikit-learn; install it with pip install 'brushgrip[networks]'"
        ) from None
    network = MLPRegressor(
        hidden_layer_sizes=design.hidden,
        activation=design.activation.value,
        alpha=0.0,
        batch_size=design.batch,
        learning_rate_init=design.rate,
        max_iter=design.epochs,
        early_stopping=True,
        n_iter_no_change=design.epochs,
        validation_fraction=design.held_back,
        random_state=design.seed,
    )
    return TransformedTargetRegressor(
        make_pipeline(StandardScaler(), network), transformer=StandardScaler()
    )
