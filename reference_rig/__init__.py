"""Independent reference rig: a fine grid of bristles in plain NumPy, and recordings made on it.

It shares no code with the packages under test. See `simulate`, `make_recording` and `campaign`.
"""
