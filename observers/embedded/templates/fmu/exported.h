/* ${fmi|upper}(${fmi}Status, DoStep)(...) is ${fmi}Status ${fmi}DoStep(...), to be seen from outside, behind the importer's
   prefix where the sources are linked into a program. */
#ifdef ${fmi|upper}_FUNCTION_PREFIX
#define ${fmi|upper}_JOINED(prefix, name) prefix##name
#define ${fmi|upper}_PREFIXED(prefix, name) ${fmi|upper}_JOINED(prefix, name)
#define ${fmi|upper}_NAME(name) ${fmi|upper}_PREFIXED(${fmi|upper}_FUNCTION_PREFIX, ${fmi}##name)
#else
#define ${fmi|upper}_NAME(name) ${fmi}##name
#endif

#if defined _WIN32
#define ${fmi|upper}(type, name) __declspec(dllexport) type ${fmi|upper}_NAME(name)
#elif defined __GNUC__
#define ${fmi|upper}(type, name) __attribute__((visibility("default"))) type ${fmi|upper}_NAME(name)
#else
#define ${fmi|upper}(type, name) type ${fmi|upper}_NAME(name)
#endif

#endif
