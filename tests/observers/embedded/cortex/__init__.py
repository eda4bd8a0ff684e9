"""Generated code on an emulated Cortex-M: compiled, run along a recording, measured."""
