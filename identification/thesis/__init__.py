"""Methods of [Györök 2022] for comparison: FFT and decrement, networks, towing, published estimates."""

from identification.thesis.author_estimate import (
    AuthorEstimate,
    aligned,
    author_file,
    read_author_estimate,
)
from identification.thesis.fft_decrement import DecrementEstimate, estimate_by_decrement
from identification.thesis.friction_network import Activation, Design, FrictionNetwork, label_mean, train

__all__ = [
    "Activation",
    "AuthorEstimate",
    "DecrementEstimate",
    "Design",
    "FrictionNetwork",
    "aligned",
    "author_file",
    "estimate_by_decrement",
    "label_mean",
    "read_author_estimate",
    "train",
]
