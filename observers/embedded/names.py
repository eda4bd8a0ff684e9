"""Names for generated code: any but those of a file beside it, of a target of CMake, and of C."""

import re

from symbolic import InvalidInputError


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


FIXED = _words("""
    main check example fmi2 simstruc simulink cg_sfun
    m all clean depend edit_cache help install package package_source rebuild_cache test
""")
"""Files that are written or included by these names, and targets of CMake."""
KEYWORDS = _words("""
    alignas alignof asm auto bool break case char const constexpr continue default do double else enum
    extern false float for goto if inline int long nullptr register restrict return short signed sizeof
    static static_assert struct switch thread_local true typedef typeof typeof_unqual union unsigned void
    volatile while
""")
"""Of C, up to C23."""
HEADERS = _words("""
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign
    stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath
    threads time uchar wchar wctype
    alloca corecrt endian features malloc memory newlib picolibc sal strings unistd vcruntime
""")
"""Of the standard library, and what its headers include: `name`.h would be found in their place."""
FUNCTIONS = _words("""
    abort abs aligned_alloc at_quick_exit atexit atof atoi atol atoll bsearch calloc div exit free getenv
    labs ldiv llabs lldiv mblen mbstowcs mbtowc qsort quick_exit rand realloc srand strtod strtof strtol
    strtold strtoll strtoul strtoull system wcstombs wctomb
    clearerr fclose feof ferror fflush fgetc fgetpos fgets fopen fprintf fputc fputs fread freopen fscanf
    fseek fsetpos ftell fwrite getc getchar gets perror printf putc putchar puts remove rename rewind
    scanf setbuf setvbuf snprintf sprintf sscanf tmpfile tmpnam ungetc vfprintf vfscanf vprintf vscanf
    vsnprintf vsprintf vsscanf
    memchr memcmp memcpy memmove memset strcat strchr strcmp strcoll strcpy strcspn strerror strlen
    strncat strncmp strncpy strpbrk strrchr strspn strstr strtok strxfrm
""")
"""Of stdlib.h, stdio.h and string.h."""
MATH_H = re.compile(
    r"(a?(cos|sin|tan)h?|atan2|cbrt|ceil|copysign|erfc?|exp2?|expm1|fabs|fdim|floor|fma|fmax|fmin|fmod|"
    r"frexp|hypot|ilogb|ldexp|[lt]gamma|ll?rint|ll?round|log(10|1p|2|b)?|modf|nan|nearbyint|nextafter|"
    r"nexttoward|pow|remainder|remquo|rint|round|scalbl?n|sqrt|trunc)[fl]?|"
    r"fpclassify|isfinite|isinf|isnan|isnormal|signbit|is(greater|less)(equal)?|islessgreater|isunordered"
)
"""Functions and macros of math.h in every type."""


def require_usable(name: str) -> None:
    """Refuses a name that generated code cannot have.

    Raises:
        InvalidInputError: it is no name in C, or it is taken.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,30}", name):
        raise InvalidInputError(
            f"name must be a name in C, small letters, digits and _, at most 31, got {name!r}"
        )
    taken = {
        "a file beside the code, or a target of CMake": name in FIXED,
        "a keyword of C": name in KEYWORDS,
        "a header of C": name in HEADERS,
        "a function of C": name in FUNCTIONS or MATH_H.fullmatch(name),
    }
    for owner in (owner for owner, is_taken in taken.items() if is_taken):
        raise InvalidInputError(f"name must not be that of {owner}, got {name!r}")
