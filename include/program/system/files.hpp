// Files that one rank writes, whole or not at all, and the one line about those that cannot be written.
#pragma once

#include <string>
#include <unistd.h>
#include <utility>

namespace mlgimp
{

/// Owns what a number stands for, a file or an object of HDF5, and closes it by a function; a negative number is none.
template <class Id> class Owned
{
public:
  Owned() = default;
  Owned(Id id, int (*close)(Id)) : id_(id), close_(close) {}
  Owned(Owned &&other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Owned &operator=(Owned &&other) noexcept
  {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Owned() { Close(); }
  /// False where that fails, for instance when what was still to be written did not fit on the disk; of a file with errno.
  bool Close()
  {
    const Id id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }
  operator Id() const { return id_; }
  bool Valid() const { return id_ >= 0; }

private:
  Id id_ = -1;
  int (*close_)(Id) = nullptr;
};
using Descriptor = Owned<int>; ///< of the system, which `close` closes

/// "cannot write PATH: REASON"; error: what errno was, or 0 where the system gave no reason.
std::string CannotWrite(const std::string &path, int error);

/// Writes all of a text; false, with errno, where that fails.
bool WriteAll(int file, const std::string &text);

/// Writes a text file under another name and renames it when it is complete. Empty, or what CannotWrite says.
std::string ReplaceFile(const std::string &path, const std::string &text);

/// True while a path leads to the file that is open: false when the file was removed or replaced.
bool SameFile(int file, const std::string &path);

} // namespace mlgimp
