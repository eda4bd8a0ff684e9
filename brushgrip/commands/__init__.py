"""The commands, one file each: the options of each as a frozen dataclass, and what it does with them."""
