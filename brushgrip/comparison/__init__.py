"""Methods compared as in Table 6.1 of [Györök 2022]; an observer of a user's own as an `ObserverMethod`."""
