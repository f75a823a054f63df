// A seal on a file: a last line with a checksum of all bytes before it, which tells a whole file from one that was cut or
// changed. Readers of HDF5 do not mind what follows the end that the file itself names.
#pragma once

#include <string>

namespace mlgimp
{

/// Adds the seal to a file without one; false, with errno, where that fails. One rank.
bool Seal(const std::string &path);

/// none: no seal at the end, or no file that can be read; broken: the file is not as it was sealed.
enum class SealState { kNone, kBroken, kWhole };
SealState FindSeal(const std::string &path); ///< One rank.

} // namespace mlgimp
