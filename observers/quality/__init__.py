"""Which samples and estimates count: screening, acquisition, tests of the innovation, supervision."""
