// Reading of command-line options with their text, unit, range and default, and one-line errors about them.
#pragma once

#include "base/petsc.hpp"
#include "base/tensor.hpp"
#include "base/text.hpp"
#include "program/system/errors.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

inline constexpr std::size_t kLongestValue = 65535; ///< size: characters of an option's value

/// The interval that a number must lie in.
struct Range {
  double lower, upper;
  bool lower_open, upper_open;
  bool Contains(double x) const { return (lower_open ? x > lower : x >= lower) && (upper_open ? x < upper : x <= upper); }
  std::string Text() const;
};
inline constexpr Range kAnyNumber = {-HUGE_VAL, HUGE_VAL, true, true}, kPositive = {0, HUGE_VAL, true, true},
                       kNotNegative = {0, HUGE_VAL, false, true}; // size
inline Range Open(double lower, double upper) { return {lower, upper, true, true}; }
inline Range Closed(double lower, double upper) { return {lower, upper, false, false}; }

/// One option as the user sees it.
struct OptionText {
  std::string name;      ///< with the dash
  std::string help;      ///< one sentence
  std::string unit = ""; ///< empty for none
};

/// A refusal that is not printed yet, so that what may be behind it is looked for first: see ReadCase.
struct InputRefused : Refused {
  using Refused::Refused;
};

/// Reads options between PetscOptionsBegin and PetscOptionsEnd, so that -help lists them. Every function refuses a value that is
/// missing or not allowed (see Refuse). With -help nothing is required.
class OptionReader
{
public:
  OptionReader(MPI_Comm comm, bool help) : comm_(comm), help_(help) {}
  void SetItems(OptionItems items) { items_ = items; }

  /// From now on reads nothing but lists of names, and learns which options there are, with those of each name.
  void OnlyLearnNames() { help_ = learns_ = true; }
  const std::vector<std::string> &Known() const { return known_; }

  bool Help() const { return help_; }
  MPI_Comm Comm() const { return comm_; }

  /// While on (the default), options count for the identity of the case that a restart checks.
  void Identify(bool on) { identify_ = on; }
  /// What the program itself has chosen for an option that was not given, for the identity.
  void Chosen(const std::string &name, double value);
  /// "name value" of every option that counts for the identity.
  const std::vector<std::string> &Identity() const { return identity_; }

  // Those that return a truth value: whether the option was given.
  bool Text(const OptionText &option, bool required, std::string *value);
  void Flag(const OptionText &option, bool *value);
  /// One of PETSc's viewers, which is opened to see that it can be; what shows an object by it reads the option anew.
  void Viewer(const OptionText &option);
  /// Returns the place of the value among the choices.
  int Choice(const OptionText &option, const std::vector<std::string> &choices, std::string *value);
  void Integer(const OptionText &option, const Range &range, int *value);
  bool Number(const OptionText &option, const Range &range, bool required, double *value);
  /// A number that may be `inf`, which is always in range.
  void NumberOrInfinity(const OptionText &option, const Range &range, double *value);
  /// A list of at least `least` numbers; at most `most` where that is not 0.
  bool Numbers(const OptionText &option, const Range &range, std::size_t least, std::size_t most, bool required,
               std::vector<double> *values);
  /// As many numbers as the geometry has dimensions; see SetDim.
  bool Vector(const OptionText &option, bool required, Vec3 *value);
  void SetDim(int dim) { dim_ = dim; }
  int Dim() const { return dim_; }
  std::string Text(Vec3 x) const;
  /// A list of names, each a letter followed by letters, digits or underscores, none twice.
  void Names(const OptionText &option, bool required, std::vector<std::string> *names);

  /// Throws InputRefused: "name value: must be allowed".
  [[noreturn]] static void Refuse(const std::string &name, const std::string &value, const std::string &allowed);
  template <class... Values>
  [[noreturn]] static void Refuse(const std::string &name, const std::string &value, const char *allowed, const Values &...values)
  {
    Refuse(name, value, Format(allowed, values...));
  }
  /// Ends the run if an option was given that nothing has read, with the nearest known name. Options of PETSc may be read
  /// later: what looks like one passes.
  void RefuseUnused() const;
  /// The same of an option that no case has, before all are read. all: the names of those that any case has.
  static void RefuseMisspelt(std::vector<std::string> all);
  /// Lists them at the end of a run.
  void WarnUnused() const;
  /// Keeps a warning until all input is accepted: what is refused gets one line.
  template <class... Values> void WarnLater(const char *line, const Values &...values)
  {
    warnings_.push_back(Format(line, values...));
  }
  const std::vector<std::string> &Warnings() const { return warnings_; }

private:
  bool Raw(const OptionText &option, const std::string &fallback, std::string *value);

  MPI_Comm comm_;
  int dim_ = 2;
  bool help_, learns_ = false, identify_ = true;
  OptionItems items_ = nullptr;
  std::vector<std::string> known_, identity_, warnings_;
};

std::string Join(const std::vector<std::string> &words, const std::string &separator);
std::vector<std::string> Split(const std::string &text, char separator);

/// A name as PETSc compares it.
std::string LowerCase(std::string name);

/// A value as messages show it: the first 200 characters.
std::string Shortened(const std::string &value);

} // namespace mlgimp
