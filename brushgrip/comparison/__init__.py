"""Methods compared as in Table 6.1 of [Györök 2022].

A case is a recording with a reference mu (cases), a method estimates friction over it (methods, and the
networks of [Györök 2022] in networks); their errors and times (scores) become tables (tables).
An observer of a user's own is compared as an `ObserverMethod`.
"""
