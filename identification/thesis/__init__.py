"""Methods of [Györök 2022] for comparison: FFT and decrement, networks, towing, published estimates."""

from identification.thesis.friction_neural_network import (
    Activation,
    FrictionNetwork,
    NetworkDesign,
    label_mean,
    train_network,
)
from identification.thesis.published_author_estimate import (
    AuthorEstimate,
    author_estimate_file,
    begin_of_part,
    read_author_estimate,
)
from identification.thesis.stiffness_by_fft_and_decrement import (
    DecrementIdentification,
    estimate_by_decrement,
)

__all__ = [
    "Activation",
    "AuthorEstimate",
    "DecrementIdentification",
    "FrictionNetwork",
    "NetworkDesign",
    "author_estimate_file",
    "begin_of_part",
    "estimate_by_decrement",
    "label_mean",
    "read_author_estimate",
    "train_network",
]
