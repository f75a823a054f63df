// The folder that a run writes into: which files there are its own, what is refused, the lock, and what a restart removes.
#pragma once

#include "program/case/case.hpp"
#include "program/system/files.hpp"

#include <string>

namespace mlgimp
{

class OutputFolder
{
public:
  /// The settings are kept by reference and must outlive the folder.
  explicit OutputFolder(const OutputSettings &settings) : settings_(settings) {}
  OutputFolder(const OutputFolder &) = delete;
  OutputFolder &operator=(const OutputFolder &) = delete;
  ~OutputFolder() { Unlock(); }

  /// Whether results may go there, without changing anything. Returns what is wrong, empty or one line, here and below the
  /// same on every rank. Collective, as the next two.
  std::string Check(MPI_Comm comm);
  /// Creates and locks the folder.
  std::string Claim(MPI_Comm comm);
  /// Removes what an earlier run left: all of its results, or, after a restart at `step` in the run's own folder, what is not
  /// complete and checkpoints and frames later than `step` and `frames`. Never the checkpoint that the run goes on from.
  std::string Clear(MPI_Comm comm, long step, int frames);
  /// True for a restart in the folder of the run that it goes on with.
  bool GoesOn() const { return goes_on_; }
  /// Where the folder could not be locked: one line that says so, or nothing; after Claim.
  const std::string &Warning() const { return warning_; }
  /// Gives the lock back, which else the system does when the process ends, however it ends.
  void Unlock();

private:
  std::string Check();
  std::string Lock();
  bool IsRestart(const std::string &path) const;
  bool HoldsRestart(const std::vector<std::string> &names) const;
  bool IsStale(const std::string &name, long step, int frames) const;
  std::string PathOf(const std::string &name) const { return settings_.directory + "/" + name; }

  const OutputSettings &settings_;
  Descriptor lock_; ///< on the first rank
  bool goes_on_ = false;
  std::string warning_;
};

} // namespace mlgimp
