// Checks, locks and clears the folder of a run; the first rank does it for all ranks.
#include "program/output/output_folder.hpp"

#include "program/system/agree.hpp"
#include "program/system/hdf5_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <regex>
#include <sys/file.h>

namespace mlgimp
{

namespace fs = std::filesystem;

static constexpr char kLockName[] = ".mlgimp_lock";

/// A file that a run writes, known by its full name; all other files in the folder are the user's.
struct Result {
  enum Kind { kNone, kLog, kSeries, kFrame, kCheckpoint } kind = kNone;
  long number = 0;   ///< of a frame or a checkpoint
  bool part = false; ///< not complete
};

static Result ResultOf(const std::string &name)
{
  static const std::regex kLog("(history\\.csv|summary\\.json)(\\.part)?"), kSeries("(points|surface)\\.(vtkhdf|xdmf)(\\.part)?"),
      kNumbered("(points|checkpoint)_([0-9]{6}|[1-9][0-9]{6,17})\\.h5(\\.part)?"); // six digits or more, as it is written
  std::smatch found;
  if (std::regex_match(name, found, kLog)) return {Result::kLog, 0, found[2].matched};
  if (std::regex_match(name, found, kSeries)) return {Result::kSeries, 0, found[3].matched};
  if (!std::regex_match(name, found, kNumbered)) return {};
  return {found[1] == "points" ? Result::kFrame : Result::kCheckpoint, std::stol(found[2]), found[3].matched};
}

/// Names of the results in a folder, and of folders in their way; false, with the reason, where it cannot be listed.
static bool ListResults(const std::string &directory, std::vector<std::string> *files, std::vector<std::string> *folders,
                        std::error_code *error)
{
  for (fs::directory_iterator entry(directory, *error), end; !*error && entry != end; entry.increment(*error)) {
    const std::string name = entry->path().filename().string();
    std::error_code unknown;
    if (ResultOf(name).kind == Result::kNone) continue;
    (fs::is_directory(entry->symlink_status(unknown)) ? folders : files)->push_back(name);
  }
  return !*error;
}

/// True for the checkpoint that the run goes on from, by whatever name or link.
bool OutputFolder::IsRestart(const std::string &path) const
{
  std::error_code error;
  return !settings_.restart.empty() && fs::equivalent(path, settings_.restart, error);
}

/// True where the run goes on in the folder that the checkpoint lies in, be it named there by a link.
bool OutputFolder::HoldsRestart(const std::vector<std::string> &names) const
{
  std::error_code error;
  if (settings_.restart.empty()) return false;
  for (const fs::path &file : {fs::path(settings_.restart), fs::canonical(settings_.restart, error)}) {
    const fs::path folder = file.parent_path();
    if (!file.empty() && fs::equivalent(folder.empty() ? "." : folder, settings_.directory, error)) return true;
  }
  return std::any_of(names.begin(), names.end(), [&](const std::string &name) { return IsRestart(PathOf(name)); });
}

/// What is wrong with the folder as it is; empty where nothing is, or where there is none yet.
std::string OutputFolder::Check()
{
  const std::string option = Format("-output_dir {}: must ", Shortened(settings_.directory));
  std::vector<std::string> files, folders;
  std::error_code error, unknown;
  goes_on_ = false;
  const fs::file_status status = fs::status(settings_.directory, unknown);
  if (status.type() == fs::file_type::unknown) return Format("{}be a folder that can be reached: {}", option, unknown.message());
  if (!fs::exists(status)) return "";
  if (!fs::is_directory(status)) return Format("{}be a folder; it is a file", option);
  if (!ListResults(settings_.directory, &files, &folders, &error))
    return Format("{}be a folder that can be listed: {}", option, error.message());
  if (!folders.empty()) return Format("{}hold no folder {}, the name of a result", option, folders[0]);
  goes_on_ = HoldsRestart(files);
  if (!files.empty() && !goes_on_ && !settings_.overwrite) return Format("{}hold no results, or -overwrite be given", option);
  return "";
}

/// Locks a file of its own, since the results are replaced by renaming. A file that a killed run left is not locked any more.
std::string OutputFolder::Lock()
{
  const std::string path = PathOf(kLockName), option = Format("-output_dir {}: ", Shortened(settings_.directory));
  do {
    lock_ = Descriptor(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666), close);
    if (!lock_.Valid()) return ""; // where no file can be made, the first result says why
    if (flock(lock_, LOCK_EX | LOCK_NB) == 0) continue;
    const int error = errno;
    if (error == EWOULDBLOCK) {
      lock_.Close();
      return Format("{}must be used by one run at a time; another is writing there", option);
    }
    warning_ = Format("{}the file system gives no locks ({}): two runs in this folder at once would not be noticed, and on NFS "
                      "all ranks must be on one machine",
                      option, std::strerror(error));
  } while (!SameFile(lock_, path)); // the run before has just removed it
  return "";
}

void OutputFolder::Unlock()
{
  if (lock_.Valid() && SameFile(lock_, PathOf(kLockName))) unlink(PathOf(kLockName).c_str());
  lock_.Close();
}

std::string OutputFolder::Check(MPI_Comm comm)
{
  return OnFirstRank(comm, "folder_check", [&] { return Check(); });
}

/// Of the results in the folder, those that the run does without.
bool OutputFolder::IsStale(const std::string &name, long step, int frames) const
{
  const Result result = ResultOf(name);
  if (IsRestart(PathOf(name))) return false;
  if (!goes_on_ || result.part) return true;
  return (result.kind == Result::kCheckpoint && result.number > step) ||
         (result.kind == Result::kFrame && result.number > frames) || (result.kind == Result::kSeries && frames < 0);
}

std::string OutputFolder::Claim(MPI_Comm comm)
{
  std::string problem = OnFirstRank(comm, "folder_claim", [&] {
    std::error_code error, unknown;
    fs::create_directories(settings_.directory, error);
    if (!fs::is_directory(settings_.directory, unknown))
      return Format("-output_dir {}: must be a folder that can be created: {}", Shortened(settings_.directory), error.message());
    const std::string taken = Lock();
    return taken.empty() ? Check() : taken; // once more: another run may have come between
  });
  MPI_Bcast(&goes_on_, 1, MPI_CXX_BOOL, 0, comm);
  warning_ = ShareText(comm, warning_);
  if (!warning_.empty()) DoWithoutLocks();
  return problem;
}

std::string OutputFolder::Clear(MPI_Comm comm, long step, int frames)
{
  return OnFirstRank(comm, "folder_clear", [&]() -> std::string {
    std::error_code error;
    std::vector<std::string> files, folders;
    if (!ListResults(settings_.directory, &files, &folders, &error)) return CannotWrite(settings_.directory, error.value());
    for (const std::string &name : files)
      if (IsStale(name, step, frames)) fs::remove(PathOf(name), error);
    return "";
  });
}

} // namespace mlgimp
