// All options of a case.
#pragma once

#include "program/case/case.hpp"

namespace mlgimp
{

/// Reads and checks all options of a case. With -help nothing is required and nothing is checked.
void ReadCase(OptionReader &reader, Case *settings);

} // namespace mlgimp
