"""How models become machine code: C of them, its compiler, and the cache of what it built."""
