// VOXCONE_CHECK(condition, "format", values...): an assertion of our own invariants, on in every build type. A failure
// prints expression, place and values, then aborts: it is a bug, not bad input.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#define VOXCONE_CHECK(condition, ...)                                                             \
    do {                                                                                          \
        if (!(condition)) {                                                                       \
            std::fprintf(stderr, "voxcone: bug: %s:%d: %s: %s\n", __FILE__, __LINE__, #condition, \
                         fmt::format(__VA_ARGS__).c_str());                                       \
            std::abort();                                                                         \
        }                                                                                         \
    } while (false)
