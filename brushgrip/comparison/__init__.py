"""Methods compared as in Table 6.1 of [Györök 2022].

A case is a recording with a reference mu (cases), a method estimates friction over it (methods, and the
networks of [Györök 2022] in networks); their errors and times (scores) become tables (tables).
An observer of a user's own is compared as an `ObserverMethod`.
"""

from brushgrip.comparison.cases import Case, make_case
from brushgrip.comparison.method_scores import CaseScores, MethodSummary, Score, compare, summarise
from brushgrip.comparison.methods import Method, ObserverMethod, default_methods
from brushgrip.comparison.tables import comparison_dict, markdown_text

__all__ = [
    "Case",
    "CaseScores",
    "Method",
    "MethodSummary",
    "ObserverMethod",
    "Score",
    "compare",
    "comparison_dict",
    "default_methods",
    "make_case",
    "markdown_text",
    "summarise",
]
