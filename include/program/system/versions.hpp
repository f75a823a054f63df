// The versions of the program and of the libraries that it runs with.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace mlgimp
{

/// Names and versions, the program's first. Call after MPI_Init.
std::vector<std::pair<std::string, std::string>> Versions();

} // namespace mlgimp
