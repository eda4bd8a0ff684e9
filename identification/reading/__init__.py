"""Recordings and rigs from files: one pipeline from bytes to `Recording`.

::

    bytes       checked_file_reading     a regular file of bounded size, as bytes or as text
      |
    channels    formats/*                open a file, list its channels, read those asked for:
      |                                  `ChannelSamples`, with their unit and, if any, a clock
      |         channels_by_name         which is which column, as a map or its name says (signal_map)
      |         common_clock_and_units   columns in SI (units) and on one clock
    Table       checked_sample_table     the checks of every sample, the first fault by its place
      |
      |         rigfile                  values that the file declares, else those of the rig file
      |         yaw_rate_from_angle      the yaw rate where none was recorded
    Recording   recordings               gaps filled; causal, from the first complete sample on

`readers` is the registry: by the suffix of a file, the function that goes from bytes to `Table`. A
reader of one's own is such a function in one file (`examples/own_reader.py`).

Two ways round it: `conditioning` makes a recording out of raw channels in volts, `trimming_and_thinning`
thins recordings that are too long for a search.
"""
