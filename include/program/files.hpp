// Files that one rank writes, whole or not at all, and the one line about those that cannot be written.
#pragma once

#include <string>
#include <unistd.h>

namespace mlgimp
{

/// Owns a file descriptor.
class Descriptor
{
public:
  Descriptor() = default;
  explicit Descriptor(int id) : id_(id) {}
  Descriptor(const Descriptor &) = delete;
  Descriptor &operator=(const Descriptor &) = delete;
  ~Descriptor() { Close(); }
  void Reset(int id)
  {
    Close();
    id_ = id;
  }
  /// False, with errno, where what was written could not be kept.
  bool Close()
  {
    const int id = id_;
    id_ = -1;
    return id < 0 || close(id) == 0;
  }
  operator int() const { return id_; }
  bool Valid() const { return id_ >= 0; }

private:
  int id_ = -1;
};

/// "cannot write PATH: REASON"; error: what errno was, or 0 where the system gave no reason.
std::string CannotWrite(const std::string &path, int error);

/// Writes all of a text; false, with errno, where that fails.
bool WriteAll(int file, const std::string &text);

/// Writes a text file under another name and renames it when it is complete. Empty, or what CannotWrite says.
std::string ReplaceFile(const std::string &path, const std::string &text);

/// True while a path leads to the file that is open: not where somebody has removed or replaced it.
bool SameFile(int file, const std::string &path);

} // namespace mlgimp
