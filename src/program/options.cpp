// Option reading on PETSc's options database.
#include "program/options.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <numeric>
#include <set>

namespace mlgimp
{

std::string FormatNumber(double x)
{
  char buffer[32];
  for (int digits : {6, 12, 17}) { // the shortest that reads back as x
    std::snprintf(buffer, sizeof buffer, "%.*g", digits, x);
    if (std::strtod(buffer, nullptr) == x) break;
  }
  return buffer;
}

std::string FormatRounded(double x)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

std::string FormatVector(Vec3 x, int dim)
{
  return FormatNumber(x[0]) + "," + FormatNumber(x[1]) + (dim == 3 ? "," + FormatNumber(x[2]) : "");
}

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
  return std::string("in ") + (lower_open ? "(" : "[") + FormatNumber(lower) + ", " + FormatNumber(upper) +
         (upper_open ? ")" : "]");
}

std::string Shortened(const std::string &value)
{
  constexpr std::size_t kMost = 200;
  return value.size() <= kMost ? value : value.substr(0, kMost) + "... (" + std::to_string(value.size()) + " characters)";
}

static bool ParseNumber(const std::string &text, double *value)
{
  char *end = nullptr;
  *value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(*value) && !std::isspace(static_cast<unsigned char>(text[0]));
}

PetscErrorCode OptionReader::Refuse(const std::string &name, const std::string &value, const std::string &allowed) const
{
  PetscFunctionBeginUser;
  const std::string shown = value.empty() ? "" : " " + Shortened(value);
  PetscCall(mlgimp::Refuse(comm_, name + shown + ": must be " + allowed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Raw(const OptionText &option, const std::string &fallback, std::string *value, bool *given)
{
  std::vector<char> buffer(kLongestValue + 1);
  PetscBool set = PETSC_FALSE;
  auto PetscOptionsObject = items_;
  PetscFunctionBeginUser;
  if (std::find(known_.begin(), known_.end(), option.name) != known_.end())
    PetscCall(Refuse(option.name, "", "an option of one meaning; give the body, material or load another name"));
  const std::string help = option.help + (option.unit.empty() ? "" : " [" + option.unit + "]");
  PetscCall(PetscOptionsString(option.name.c_str(), help.c_str(), nullptr, fallback.c_str(), buffer.data(), buffer.size(), &set));
  *given = set;
  *value = set ? buffer.data() : fallback;
  known_.push_back(option.name);
  if (identify_) identity_.push_back(option.name + " " + *value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Text(const OptionText &option, bool required, std::string *value, bool *given)
{
  bool set = false;
  std::string text;
  PetscFunctionBeginUser;
  PetscCall(Raw(option, required ? "required" : *value, &text, &set));
  if (given) *given = set;
  if (!set && required && !help_) PetscCall(Refuse(option.name, "", "given: " + option.help));
  if (set && text.empty()) PetscCall(Refuse(option.name, "(nothing)", "given a value: " + option.help));
  if (set) *value = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Flag(const OptionText &option, bool *value)
{
  bool given = false;
  std::string text;
  PetscFunctionBeginUser;
  PetscCall(Raw(option, *value ? "true" : "false", &text, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  const std::set<std::string> yes = {"", "1", "true", "yes", "on"}, no = {"0", "false", "no", "off"};
  if (!yes.count(text) && !no.count(text)) PetscCall(Refuse(option.name, text, "true or false"));
  *value = yes.count(text) > 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Choice(const OptionText &option, const std::vector<std::string> &choices, std::string *value)
{
  bool given = false;
  OptionText listed = option;
  PetscFunctionBeginUser;
  listed.help += ": " + Join(choices, ", ");
  std::string text = *value;
  PetscCall(Raw(listed, *value, &text, &given));
  if (std::find(choices.begin(), choices.end(), text) == choices.end())
    PetscCall(Refuse(option.name, text.empty() ? "(nothing)" : text, "one of " + Join(choices, ", ")));
  *value = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Integer(const OptionText &option, const Range &range, int *value)
{
  bool given = false;
  std::string text;
  double number;
  PetscFunctionBeginUser;
  PetscCall(Raw(option, std::to_string(*value), &text, &given));
  if (!ParseNumber(text, &number) || !range.Contains(number) || number != std::floor(number) || std::abs(number) > 2e9)
    PetscCall(Refuse(option.name, text.empty() ? "(nothing)" : text, "a whole number " + range.Text()));
  *value = static_cast<int>(number);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Number(const OptionText &option, const Range &range, bool required, double *value, bool *given)
{
  std::vector<double> values(1, *value);
  PetscFunctionBeginUser;
  PetscCall(Numbers(option, range, 1, 1, required, &values, given));
  *value = values[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Numbers(const OptionText &option, const Range &range, std::size_t least, std::size_t most,
                                     bool required, std::vector<double> *values, bool *given)
{
  bool set = false;
  std::string text;
  std::vector<std::string> defaults;
  PetscFunctionBeginUser;
  for (double value : *values) defaults.push_back(std::isfinite(value) ? FormatNumber(value) : "none");
  PetscCall(Raw(option, required ? "required" : defaults.empty() ? "none" : Join(defaults, ","), &text, &set));
  if (given) *given = set;
  const std::string fewest = most == least ? "" : least > 1 ? "at least " : "";
  const std::string count = most == 1 ? "" : fewest + (least > 1 ? std::to_string(least) + " " : "") + "numbers ";
  if (!set) {
    if (required && !help_) PetscCall(Refuse(option.name, "", "given: " + option.help));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  values->clear();
  bool allowed = true;
  for (const std::string &word : Split(text, ',')) {
    double value = 0;
    allowed = allowed && ParseNumber(word, &value) && range.Contains(value);
    values->push_back(value);
  }
  if (!allowed || values->size() < least || (most && values->size() > most))
    PetscCall(Refuse(option.name, text.empty() ? "(nothing)" : text,
                     count + (count.empty() || range.Text() != "a number" ? range.Text() : "separated by commas")));
  if (identify_) { // 1 and 1.0 are the same case
    std::vector<std::string> canonical;
    for (double value : *values) canonical.push_back(FormatNumber(value));
    identity_.back() = option.name + " " + Join(canonical, ",");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string OptionReader::Text(Vec3 x) const { return FormatVector(x, dim_); }

PetscErrorCode OptionReader::Vector(const OptionText &option, bool required, Vec3 *value, bool *given)
{
  std::vector<double> values(value->begin(), value->begin() + dim_);
  PetscFunctionBeginUser;
  PetscCall(Numbers(option, kAnyNumber, dim_, dim_, required, &values, given));
  std::copy_n(values.begin(), dim_, value->begin());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::Names(const OptionText &option, bool required, std::vector<std::string> *names)
{
  std::string text;
  bool given = false;
  PetscFunctionBeginUser;
  PetscCall(Text(option, required, &text, &given));
  names->clear();
  if (help_ && !given) *names = {"NAME"};
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  for (const std::string &name : Split(text, ',')) {
    bool valid = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0]));
    for (char c : name) valid = valid && (std::isalnum(static_cast<unsigned char>(c)) || c == '_');
    if (!valid || std::find(names->begin(), names->end(), name) != names->end())
      PetscCall(Refuse(option.name, text, "different names of letters, digits and underscores, separated by commas"));
    names->push_back(name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
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

PetscErrorCode OptionReader::FindUnused(std::vector<std::string> *unused)
{
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  for (PetscInt k = 0; k < count; ++k) unused->push_back(std::string("-") + names[k]);
  PetscCall(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
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
  if (name.rfind("contact_", 0) == 0) name = name.substr(8);
  if (name.find("_view") != std::string::npos || name.find("_monitor") != std::string::npos) return true;
  return std::any_of(std::begin(kStarts), std::end(kStarts), [&](const char *start) { return name.rfind(start, 0) == 0; });
}

PetscErrorCode OptionReader::RefuseUnused() const
{
  constexpr std::size_t kNear = 2; // typing errors
  std::vector<std::string> all;
  PetscFunctionBeginUser;
  PetscCall(FindUnused(&all));
  for (const std::string &unused : all) {
    if (std::find(known_.begin(), known_.end(), unused) != known_.end())
      PetscCall(mlgimp::Refuse(comm_, Shortened(unused) + ": is not used in this case"));
    const auto nearest = std::min_element(known_.begin(), known_.end(), [&](const auto &a, const auto &b) {
      return EditDistance(unused, a) < EditDistance(unused, b);
    });
    if (EditDistance(unused, *nearest) > kNear && LooksLikePetsc(unused)) continue;
    PetscCall(mlgimp::Refuse(comm_, Shortened(unused) + ": nothing reads this option in this case; the nearest known name is " +
                                        *nearest));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::WarnUnused() const
{
  // Read by PETSc only when it finishes.
  const std::set<std::string> late = {"-options_left", "-objects_dump", "-malloc_dump", "-memory_view", "-log_view_memory"};
  std::vector<std::string> all;
  PetscFunctionBeginUser;
  PetscCall(FindUnused(&all));
  for (const std::string &unused : all)
    if (!late.count(unused))
      PetscCall(PetscFPrintf(comm_, PETSC_STDERR, "mlgimp: warning: %s: nothing has read this option\n",
                             OneLine(Shortened(unused)).c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
