"""What [Györök 2022] did with recordings, kept for comparison: FFT and decrement, networks, towing."""
