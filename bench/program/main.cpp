// Program simuli-bench, which `simuli bench` runs.
#include "bench/program/bench.hpp"

int main(int argc, char** argv) { return simuli::bench::run_bench(argc, argv); }
