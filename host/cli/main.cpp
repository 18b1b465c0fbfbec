// simuli: the program.
#include "host/cli/simuli.hpp"

int main(int argc, char** argv) { return simuli::cli::run_simuli(argc, argv); }
