"""What a command reads: recordings, rigs, channel maps, grounds, tunings and effects of the user's."""
