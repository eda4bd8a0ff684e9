"""Methods compared as in Table 6.1 of [Györök 2022].

A case is a recording with a reference mu (cases), a method estimates friction over it (methods); their
errors and times (method_scores) become tables (tables).
An observer of a user's own is compared as an `ObserverMethod`.
"""
