// The main function that every test program shares. Doctest's declarations are precompiled: this adds their bodies.
#define DOCTEST_CONFIG_IMPLEMENT
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>
