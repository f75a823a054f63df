// The checksum of a file and the line that holds it.
#include "program/seal.hpp"

#include "program/files.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <vector>

namespace mlgimp
{

namespace
{

constexpr char kSealStart[] = "\nmlgimp checksum ";
constexpr std::size_t kSealSize = sizeof kSealStart - 1 + 16; ///< with the digits of the checksum

/// 64 bits of all bytes. A step is one to one in the sum as well as in the word, so that no change of a single word is missed.
class Checksum
{
public:
  /// A multiple of eight bytes, but for the last call.
  void Add(const char *data, std::size_t size)
  {
    for (std::size_t k = 0; k < size; k += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, data + k, std::min(sizeof word, size - k));
      AddWord(word);
    }
    size_ += size;
  }
  std::string Line()
  {
    char line[kSealSize + 1];
    AddWord(size_);
    std::snprintf(line, sizeof line, "%s%016llx", kSealStart, static_cast<unsigned long long>(sum_));
    return line;
  }

private:
  void AddWord(std::uint64_t word)
  {
    sum_ = (sum_ ^ word) * 0x9e3779b97f4a7c15;
    sum_ ^= sum_ >> 32;
  }
  std::uint64_t sum_ = 0, size_ = 0;
};

/// The seal of the first `size` bytes of a file; empty, with errno, where they cannot be read.
std::string SealOf(int file, off_t size)
{
  std::vector<char> buffer(1 << 20);
  Checksum checksum;
  for (off_t done = 0; done < size;) {
    std::size_t filled = 0; // reads may be short, but only the last words of a file may be incomplete
    const std::size_t wanted = static_cast<std::size_t>(std::min<off_t>(size - done, static_cast<off_t>(buffer.size())));
    while (filled < wanted) {
      const ssize_t count = pread(file, buffer.data() + filled, wanted - filled, done + static_cast<off_t>(filled));
      if (count <= 0) return "";
      filled += static_cast<std::size_t>(count);
    }
    checksum.Add(buffer.data(), filled);
    done += static_cast<off_t>(filled);
  }
  return checksum.Line();
}

} // namespace

bool Seal(const std::string &path)
{
  Descriptor file(open(path.c_str(), O_RDWR | O_APPEND));
  if (!file.Valid()) return false;
  const off_t size = lseek(file, 0, SEEK_END);
  const std::string seal = size < 0 ? "" : SealOf(file, size);
  return !seal.empty() && WriteAll(file, seal) && file.Close();
}

SealState FindSeal(const std::string &path)
{
  char last[kSealSize];
  Descriptor file(open(path.c_str(), O_RDONLY));
  const off_t size = file.Valid() ? lseek(file, 0, SEEK_END) - static_cast<off_t>(kSealSize) : -1;
  if (size < 0 || pread(file, last, kSealSize, size) != static_cast<ssize_t>(kSealSize)) return SealState::kNone;
  const std::string found(last, kSealSize);
  if (found.rfind(kSealStart, 0) != 0) return SealState::kNone;
  return SealOf(file, size) == found ? SealState::kWhole : SealState::kBroken;
}

} // namespace mlgimp
