// Option reading on PETSc's options database.
#include "program/options/options.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <numeric>
#include <set>

namespace mlgimp
{

std::string Join(const std::vector<std::string> &words, const std::string &separator)
{
  std::string text;
  for (const std::string &word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

std::vector<std::string> Split(const std::string &text, char separator)
{
  std::vector<std::string> words(1);
  for (char c : text) {
    if (c == separator)
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

std::string Range::Text() const
{
  if (lower == -HUGE_VAL && upper == HUGE_VAL) return "a number";
  if (upper == HUGE_VAL) return (lower_open ? "> " : ">= ") + FormatNumber(lower);
  return Format("in {}{}, {}{}", lower_open ? "(" : "[", FormatNumber(lower), FormatNumber(upper), upper_open ? ")" : "]");
}

std::string Shortened(const std::string &value)
{
  constexpr std::size_t kMaxShown = 200; // size
  return value.size() <= kMaxShown ? value : Format("{}... ({} characters)", value.substr(0, kMaxShown), value.size());
}

std::string LowerCase(std::string name)
{
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

static bool ParseNumber(const std::string &text, double *value)
{
  char *end = nullptr;
  *value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(*value) && !std::isspace(static_cast<unsigned char>(text[0]));
}

void OptionReader::Refuse(const std::string &name, const std::string &value, const std::string &allowed)
{
  throw InputRefused(Format("{}{}: must be {}", name, value.empty() ? "" : " " + Shortened(value), allowed));
}

bool OptionReader::Raw(const OptionText &option, const std::string &fallback, std::string *value)
{
  std::vector<char> buffer(kLongestValue + 1);
  PetscBool given = PETSC_FALSE;
  if (std::find(known_.begin(), known_.end(), option.name) != known_.end())
    Refuse(option.name, "", "an option of one body, material or load; rename one of those that it belongs to");
  const std::string help = option.help + (option.unit.empty() ? "" : " [" + option.unit + "]");
  auto PetscOptionsObject = items_; // by this name PETSc's macro knows it
  if (!learns_)
    ExitOnError(
        PetscOptionsString(option.name.c_str(), help.c_str(), nullptr, fallback.c_str(), buffer.data(), buffer.size(), &given));
  *value = given ? buffer.data() : fallback;
  known_.push_back(option.name);
  if (identify_) identity_.push_back(option.name + " " + *value);
  return given;
}

bool OptionReader::Text(const OptionText &option, bool required, std::string *value)
{
  std::string text;
  const bool given = Raw(option, required ? "required" : *value, &text);
  if (!given && required && !help_) Refuse(option.name, "", "given: " + option.help);
  if (given && text.empty()) Refuse(option.name, "(nothing)", "given a value: " + option.help);
  if (given) *value = text;
  return given;
}

void OptionReader::Flag(const OptionText &option, bool *value)
{
  const std::set<std::string> yes = {"", "1", "true", "yes", "on"}, no = {"0", "false", "no", "off"};
  std::string text;
  if (!Raw(option, *value ? "true" : "false", &text)) return;
  if (!yes.count(text) && !no.count(text)) Refuse(option.name, text, "true or false (or yes, no, on, off, 1, 0)");
  *value = yes.count(text) > 0;
}

void OptionReader::Viewer(const OptionText &option)
{
  std::string text;
  PetscViewer viewer;
  if (!Raw(option, "none", &text) || help_) return;
  ExitOnError(PetscOptionsCreateViewer(comm_, nullptr, nullptr, option.name.c_str(), &viewer, nullptr, nullptr));
  ExitOnError(PetscViewerDestroy(&viewer));
}

int OptionReader::Choice(const OptionText &option, const std::vector<std::string> &choices, std::string *value)
{
  Raw({option.name, option.help + ": " + Join(choices, ", "), option.unit}, *value, value);
  const auto place = std::find(choices.begin(), choices.end(), *value);
  if (place == choices.end()) Refuse(option.name, value->empty() ? "(nothing)" : *value, "one of " + Join(choices, ", "));
  return static_cast<int>(place - choices.begin());
}

void OptionReader::Integer(const OptionText &option, const Range &range, int *value)
{
  std::string text;
  double number;
  Raw(option, std::to_string(*value), &text);
  constexpr double kLargestInt = 2e9; // size
  if (!ParseNumber(text, &number) || !range.Contains(number) || number != std::floor(number) || std::abs(number) > kLargestInt)
    Refuse(
        option.name, text.empty() ? "(nothing)" : text,
        Format("a whole number {}{}", range.Text(), number > kLargestInt && range.upper == HUGE_VAL ? " and at most 2e9" : ""));
  *value = static_cast<int>(number);
}

bool OptionReader::Number(const OptionText &option, const Range &range, bool required, double *value)
{
  std::vector<double> values(1, *value);
  const bool given = Numbers(option, range, 1, 1, required, &values);
  *value = values[0];
  return given;
}

void OptionReader::NumberOrInfinity(const OptionText &option, const Range &range, double *value)
{
  std::string text;
  Raw(option, FormatNumber(*value), &text);
  if (text == "inf")
    *value = HUGE_VAL;
  else if (!ParseNumber(text, value) || !range.Contains(*value))
    Refuse(option.name, text.empty() ? "(nothing)" : text, range.Text() + " or inf");
  if (identify_) identity_.back() = option.name + " " + FormatNumber(*value);
}

void OptionReader::Chosen(const std::string &name, double value)
{
  for (std::string &one : identity_)
    if (one.rfind(name + " ", 0) == 0) one = name + " " + FormatNumber(value);
}

static std::string FormatNumbers(const std::vector<double> &values)
{
  std::vector<std::string> words;
  for (double value : values) words.push_back(std::isfinite(value) ? FormatNumber(value) : "none");
  return Join(words, ",");
}

bool OptionReader::Numbers(const OptionText &option, const Range &range, std::size_t least, std::size_t most, bool required,
                           std::vector<double> *values)
{
  std::string text, strange;
  bool allowed = true;
  if (!Raw(option, required ? "required" : values->empty() ? "none" : FormatNumbers(*values), &text)) {
    if (required && !help_) Refuse(option.name, "", "given: " + option.help);
    return false;
  }
  values->clear();
  for (const std::string &word : Split(text, ',')) {
    double value = 0;
    const bool number = ParseNumber(word, &value);
    if (!number && strange.empty() && !text.empty())
      strange = Format("; {} is no finite number", word.empty() ? "(nothing)" : Shortened(word));
    allowed = allowed && number && range.Contains(value);
    values->push_back(value);
  }
  if (most == 1 && values->size() > 1) strange = Format("; one number, and not {} with commas", values->size());
  const std::string fewest = most == least ? "" : least > 1 ? "at least " : "";
  const std::string count = most == 1 ? "" : Format("{}{}numbers ", fewest, least > 1 ? Format("{} ", least) : "");
  if (!allowed || values->size() < least || (most && values->size() > most))
    Refuse(option.name, text.empty() ? "(nothing)" : text,
           count + (count.empty() || range.Text() != "a number" ? range.Text() : "separated by commas") + strange);
  if (identify_) identity_.back() = option.name + " " + FormatNumbers(*values); // 1 and 1.0 are the same case
  return true;
}

std::string OptionReader::Text(Vec3 x) const { return FormatVector(x, dim_); }

bool OptionReader::Vector(const OptionText &option, bool required, Vec3 *value)
{
  std::vector<double> values(value->begin(), value->begin() + dim_);
  const bool given = Numbers(option, kAnyNumber, dim_, dim_, required, &values);
  std::copy_n(values.begin(), dim_, value->begin());
  return given;
}

/// The value of an option, where it was given.
static bool FindValue(const std::string &name, std::string *value)
{
  std::vector<char> buffer(kLongestValue + 1);
  PetscBool given = PETSC_FALSE;
  ExitOnError(PetscOptionsGetString(nullptr, nullptr, name.c_str(), buffer.data(), buffer.size(), &given));
  *value = buffer.data();
  return given;
}

void OptionReader::Names(const OptionText &option, bool required, std::vector<std::string> *names)
{
  std::string text;
  names->clear();
  if (!Text(option, required, &text) && !(learns_ && FindValue(option.name, &text))) {
    if (help_) *names = {"NAME"};
    return;
  }
  for (const std::string &name : Split(text, ',')) {
    bool valid = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0]));
    for (char c : name) valid = valid && (std::isalnum(static_cast<unsigned char>(c)) || c == '_');
    if (!valid || std::find(names->begin(), names->end(), name) != names->end())
      Refuse(option.name, text, "different names of letters, digits and underscores, separated by commas");
    names->push_back(name);
  }
}

/// Number of insertions, deletions and replacements that turn a into b (Levenshtein).
static std::size_t EditDistance(const std::string &a, const std::string &b)
{
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// Options that the program has not read.
static std::vector<std::string> FindUnused()
{
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  std::vector<std::string> unused;
  ExitOnError(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  for (PetscInt k = 0; k < count; ++k) unused.push_back(std::string("-") + names[k]);
  ExitOnError(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  return unused;
}

/// True for names of the kind that PETSc may read after the set-up, as -mat_view, or when it finishes, as -malloc_dump.
static bool LooksLikePetsc(const std::string &option)
{
  static const char *const kStarts[] = {"mat_",   "vec_",    "ksp_",      "pc_",      "sf_",      "dm_",        "is_",
                                        "log_",   "malloc",  "memory_",   "options_", "objects_", "info",       "viewer_",
                                        "draw_",  "petsc",   "on_error",  "debug",    "start_",   "stop_",      "fp_trap",
                                        "check_", "get_",    "error_",    "saws",     "device_",  "use_gpu",    "x_",
                                        "nox",    "display", "citations", "version",  "da_",      "vecscatter_"};
  std::string name = option.substr(1);
  if (name.rfind("level_", 0) == 0) return false; // of a level that is not there
  if (name.rfind("contact_", 0) == 0) name = name.substr(8);
  if (name.find("_view") != std::string::npos || name.find("_monitor") != std::string::npos) return true;
  return std::any_of(std::begin(kStarts), std::end(kStarts), [&](const char *start) { return name.rfind(start, 0) == 0; });
}

constexpr std::size_t kMaxTypingErrors = 2; ///< size: typing errors

/// The known name that is most like an option's.
static const std::string &Nearest(const std::string &option, const std::vector<std::string> &known)
{
  return *std::min_element(known.begin(), known.end(),
                           [&](const auto &a, const auto &b) { return EditDistance(option, a) < EditDistance(option, b); });
}

/// Options of earlier versions, and why they are gone.
struct RetiredOption {
  const char *name, *reason;
};
constexpr RetiredOption kRetired[] = {
    {"-contact_width",
     "contact has a pressure on each segment of the surface, not on columns of cells with kernels of some width"},
    {"-contact_serial_unknowns",
     "the contact pressures are solved on one rank, as they take a few products with a sparse matrix"}};

[[noreturn]] static void RefuseUnknown(const std::string &option, const std::vector<std::string> &known)
{
  if (option.find('=') != std::string::npos)
    Refuse(Shortened(option) + ": a blank must be between an option's name and its value, not =");
  for (const RetiredOption &retired : kRetired)
    if (option == retired.name) Refuse("{}: is not an option any more: {}", option, retired.reason);
  Refuse("{}: unknown or unused option in this case; the nearest known name is {}", Shortened(option), Nearest(option, known));
}

void OptionReader::RefuseUnused() const
{
  for (const std::string &unused : FindUnused()) {
    if (std::find(known_.begin(), known_.end(), unused) != known_.end())
      mlgimp::Refuse(Shortened(unused) + ": is not used in this case");
    if (EditDistance(unused, Nearest(unused, known_)) > kMaxTypingErrors && LooksLikePetsc(unused)) continue;
    RefuseUnknown(unused, known_);
  }
}

/// Whether an option is like one of those known whose name begins with `start`: what follows that is its end.
static bool EndsLike(const std::string &option, const std::string &known, const std::string &start)
{
  if (known.rfind(start, 0) != 0) return false;
  const std::string end = "_" + known.substr(start.size());
  return option.size() > end.size() && option.substr(option.size() - end.size()) == end;
}

/// Whether an option is one of those known, of another level, or of a name that is in no list yet, as -NAME_lower.
static bool IsKnown(const std::string &option, const std::vector<std::string> &known)
{
  const bool of_level = option.rfind("-level_", 0) == 0, near = EditDistance(option, Nearest(option, known)) <= kMaxTypingErrors;
  return std::any_of(known.begin(), known.end(), [&](const std::string &one) {
    const bool other_level = of_level && (EndsLike(option, one, "-level_0_") || EndsLike(option, one, "-level_1_"));
    const bool of_name = !of_level && !near && EndsLike(option, one, "-NAME_");
    return option == LowerCase(one) || other_level || of_name;
  });
}

void OptionReader::RefuseMisspelt(std::vector<std::string> all)
{
  all.insert(all.end(), {"-options_file", "-help", "-version"}); // those of the command line
  for (const std::string &unused : FindUnused()) {
    const std::string option = LowerCase(unused);
    const bool of_solver = option.rfind("-contact_", 0) == 0,
               near = EditDistance(option, Nearest(option, all)) <= kMaxTypingErrors;
    const bool read_later = LooksLikePetsc(option) && (of_solver || !near);
    if (!IsKnown(option, all) && !read_later) RefuseUnknown(unused, all);
  }
}

void OptionReader::WarnUnused() const
{
  // Read by PETSc only when it finishes.
  const std::set<std::string> late = {"-options_left", "-options_view", "-objects_dump",
                                      "-malloc_dump",  "-memory_view",  "-log_view_memory"};
  for (const std::string &unused : FindUnused())
    if (!late.count(unused)) Warn(comm_, Shortened(unused) + ": unused option");
}

} // namespace mlgimp
