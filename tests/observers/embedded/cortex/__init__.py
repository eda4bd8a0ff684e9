"""Generated code on an emulated Cortex-M: built, run along a recording, measured."""
