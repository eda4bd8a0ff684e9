"""Methods of [Györök 2022] for comparison: FFT and decrement, networks, towing, published estimates."""
