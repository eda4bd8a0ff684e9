"""Methods of [Györök 2022] for comparison: FFT and decrement, networks, towing, published estimates."""

from identification.thesis.friction_network import Activation, Design, FrictionNetwork, label_mean, train
from identification.thesis.published_friction import (
    PublishedFriction,
    aligned,
    published_file,
    read_published_friction,
)
from identification.thesis.stiffness_by_fft_and_decrement import DecrementEstimate, estimate_by_decrement

__all__ = [
    "Activation",
    "DecrementEstimate",
    "Design",
    "FrictionNetwork",
    "PublishedFriction",
    "aligned",
    "estimate_by_decrement",
    "label_mean",
    "published_file",
    "read_published_friction",
    "train",
]
