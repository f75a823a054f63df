// A seal on a file: a last line with a checksum of all bytes before it, which tells a whole file from one that was cut or
// changed. Readers of HDF5 do not mind what follows the end that the file itself names.
#pragma once

#include <string>

namespace mlgimp
{

/// Adds the seal to a file without one; false, with errno, where that fails. One rank.
bool Seal(const std::string &path);

/// True for a file as it was sealed. One rank.
bool IsSealed(const std::string &path);

} // namespace mlgimp
