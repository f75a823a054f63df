// Whether a case fits into the memory of the machines it runs on.
#pragma once

#include "program/case/case.hpp"

namespace mlgimp
{

/// Ends the run with one line where a rank would need more memory than its machine has for it. Collective.
void CheckMemory(MPI_Comm comm, const Case &settings);

} // namespace mlgimp
