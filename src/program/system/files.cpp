// Writing of whole files by one rank.
#include "program/system/files.hpp"

#include "base/text.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>

namespace mlgimp
{

std::string CannotWrite(const std::string &path, int error)
{
  return Format("cannot write {}: {}", path, error ? std::strerror(error) : "the file system reports an error");
}

bool WriteAll(int file, const std::string &text)
{
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = write(file, text.data() + done, text.size() - done);
    if (written <= 0) return false;
    done += static_cast<std::size_t>(written);
  }
  return true;
}

std::string ReplaceFile(const std::string &path, const std::string &text)
{
  const std::string part = path + ".part";
  Descriptor file(open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), close);
  if (file.Valid() && WriteAll(file, text) && file.Close() && std::rename(part.c_str(), path.c_str()) == 0) return "";
  const int error = errno;
  unlink(part.c_str());
  return CannotWrite(path, error);
}

bool SameFile(int file, const std::string &path)
{
  struct stat open_one, named;
  return fstat(file, &open_one) == 0 && stat(path.c_str(), &named) == 0 && open_one.st_dev == named.st_dev &&
         open_one.st_ino == named.st_ino;
}

} // namespace mlgimp
