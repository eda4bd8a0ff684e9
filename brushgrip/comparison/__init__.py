"""Methods compared as in [Györök 2022], Table 6.1; a user's own observer as an `ObserverMethod`."""
