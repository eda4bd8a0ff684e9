"""How an observer is used: over a recording, in a loop, from files, in other packages."""
