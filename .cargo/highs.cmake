# HiGHS is compiled in units of several files: the same optimisation in half the time
# (docs/benchmarks.md, "A cold build").
set(CMAKE_UNITY_BUILD ON)
