// The program of the fast unit tests, which are in the other files here.
#include "unit/program.hpp"

int main(int argc, char **argv) { return mlgimp::RunProgram(argc, argv); }
