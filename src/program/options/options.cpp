// Option reading on PETSc's options database.
#include "program/options/options.hpp"

#include "program/options/nearest.hpp"
#include "program/options/units.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
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
  if (upper == HUGE_VAL) return Format("{} {}{}", lower_open ? ">" : ">=", FormatNumber(lower), or_infinity ? " or inf" : "");
  return Format("in {}{}, {}{}", lower_open ? "(" : "[", FormatNumber(lower), FormatNumber(upper), upper_open ? ")" : "]");
}

std::string Shortened(const std::string &value)
{
  constexpr std::size_t kMaxShown = 200; // size
  return value.size() <= kMaxShown ? value : Format("{}... ({} characters)", value.substr(0, kMaxShown), value.size());
}

static const std::string kNothing = "(nothing)"; ///< how messages show an empty value

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

namespace
{

/// A word of a value: a finite number that an option takes, or why it is none.
struct Quantity {
  double value = 0; ///< in the unit of the option
  bool has_unit = false, wrong_unit = false;
  std::string problem;
};

/// A unit that differs from one of the examples, as "kPa, MPa, GPa", in capitals alone, as a hint; empty where there is none.
std::string OtherCapitals(const std::string &name, const std::string &examples)
{
  for (std::string one : Split(examples, ',')) {
    one.erase(0, one.find_first_not_of(' '));
    if (LowerCase(one) == LowerCase(name)) return Format("; it may be {}", one);
  }
  return "";
}

/// Reads a number, or one with a unit of the option's kind behind it.
Quantity ReadQuantity(const std::string &word, const Option &option)
{
  Quantity q;
  if (ParseNumber(word, &q.value)) return q;
  char *end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  const std::string digits(word.c_str(), static_cast<const char *>(end)), name = end + std::strspn(end, " ");
  q.has_unit = true;
  if (digits.empty() || name.empty() || !std::isfinite(number) || digits.find_first_of("xX ") != std::string::npos) {
    q.problem = Format("{} is no finite number", word.empty() ? kNothing : Shortened(word));
    return q;
  }
  const std::optional<Unit> unit = ParseUnit(name), own = ParseUnit(option.unit);
  const std::string examples = own && !option.unit.empty() ? ExamplesOf(*own) : "";
  q.wrong_unit = !unit || !own || !unit->IsLike(*own);
  if (!unit)
    q.problem =
        Format("{} is no unit{}{}", Shortened(name),
               own && !option.unit.empty() ? Format(" of {} ({})", KindOf(*own), examples) : "", OtherCapitals(name, examples));
  else if (!own || !unit->IsLike(*own))
    q.problem = Format("{} is {}, {} {}", name, KindOf(*unit), option.name,
                       own ? Format("is {}", KindOf(*own)) : Format("has numbers in {}", option.unit));
  else
    q.value = unit->InBase(digits);
  return q;
}

} // namespace

void OptionReader::Throw(const std::string &name, const std::string &value, const std::string &allowed)
{
  throw InputRefused(Format("{}{}: must be {}", name, value.empty() ? "" : Format(" {}", Shortened(value)), allowed));
}

bool OptionReader::Raw(const Option &option, const std::string &fallback, std::string *value)
{
  std::vector<char> buffer(kLongestValue + 1);
  PetscBool given = PETSC_FALSE;
  if (std::find(known_.begin(), known_.end(), option.name) != known_.end())
    Refuse(option.name, "", "an option of one body, material or load; rename one of those that it belongs to");
  const std::string help = option.unit.empty() ? option.help : Format("{} [{}]", option.help, option.unit);
  auto PetscOptionsObject = items_; // by this name PETSc's macro knows it
  if (!learns_)
    ExitOnError(
        PetscOptionsString(option.name.c_str(), help.c_str(), nullptr, fallback.c_str(), buffer.data(), buffer.size(), &given));
  *value = given ? buffer.data() : fallback;
  known_.push_back(option.name);
  if (identify_) identity_.push_back(Format("{} {}", option.name, *value));
  return given;
}

template <> bool OptionReader::Read(const Option &option, std::string *value, bool required)
{
  std::string text;
  const bool given = Raw(option, required ? "required" : *value, &text);
  if (!given && required && !help_) Refuse(option.name, "", "given: {}", option.help);
  if (given && text.empty()) Refuse(option.name, kNothing, "given a value: {}", option.help);
  if (given) *value = text;
  return given;
}

template <> bool OptionReader::Read(const Option &option, bool *value, bool)
{
  const std::set<std::string> yes = {"", "1", "true", "yes", "on"}, no = {"0", "false", "no", "off"};
  std::string text;
  if (!Raw(option, *value ? "true" : "false", &text)) return false;
  if (!yes.count(text) && !no.count(text)) Refuse(option.name, text, "true or false (or yes, no, on, off, 1, 0)");
  *value = yes.count(text) > 0;
  return true;
}

template <> bool OptionReader::Read(const Option &option, int *value, bool)
{
  constexpr double kLargestInt = 2e9; // size
  std::string text;
  double number;
  const bool given = Raw(option, std::to_string(*value), &text);
  const Range &range = option.range;
  if (!ParseNumber(text, &number) || !range.Contains(number) || number != std::floor(number) || std::abs(number) > kLargestInt)
    Refuse(option.name, text.empty() ? kNothing : text, "a whole number {}{}", range.Text(),
           number > kLargestInt && range.upper == HUGE_VAL ? " and at most 2e9" : "");
  *value = static_cast<int>(number);
  return given;
}

static std::string FormatNumbers(const std::vector<double> &values, const std::string &infinite)
{
  std::vector<std::string> words;
  for (double value : values) words.push_back(std::isfinite(value) ? FormatNumber(value) : infinite);
  return Join(words, ",");
}

/// How many numbers there must be, as a message has it.
static std::string CountText(const Option &option)
{
  if (option.most == 1) return "";
  const std::string fewest = option.most != option.least && option.least > 1 ? "at least " : "";
  return Format("{}{}numbers ", fewest, option.least > 1 ? Format("{} ", option.least) : "");
}

template <> bool OptionReader::Read(const Option &option, std::vector<double> *values, bool required)
{
  const Range &range = option.range;
  std::string text, strange;
  bool allowed = true;
  if (!Raw(option, required ? "required" : values->empty() ? "none" : FormatNumbers(*values, "none"), &text)) {
    if (required && !help_) Refuse(option.name, "", "given: {}", option.help);
    return false;
  }
  values->clear();
  std::string plain; // a number without a unit
  bool has_units = false, wrong_unit = false;
  for (const std::string &word : Split(text, ',')) {
    const bool infinite = range.or_infinity && word == "inf";
    const Quantity q = infinite ? Quantity{HUGE_VAL, false, false, ""} : ReadQuantity(word, option);
    wrong_unit = wrong_unit || q.wrong_unit;
    if (strange.empty() && !text.empty() && !q.problem.empty()) strange = Format("; {}", q.problem);
    allowed = allowed && q.problem.empty() && (infinite || range.Contains(q.value));
    has_units = has_units || q.has_unit;
    if (!q.has_unit && q.value != 0 && !infinite) plain = word;
    values->push_back(q.value);
  }
  if (has_units && !plain.empty() && strange.empty()) {
    strange = Format("; {} has no unit, and others have one", plain);
    allowed = false;
  }
  if (option.most == 1 && values->size() > 1) strange = Format("; one number, and not {} with commas", values->size());
  if (wrong_unit) Refuse(option.name, text, "a number, or one with its unit{}", strange);
  const std::string count = CountText(option), kind = range.Text();
  if (!allowed || values->size() < option.least || (option.most && values->size() > option.most))
    Refuse(option.name, text.empty() ? kNothing : text, "{}{}{}", count,
           count.empty() || kind != "a number" ? kind : "separated by commas", strange);
  if (identify_) identity_.back() = Format("{} {}", option.name, FormatNumbers(*values, "inf")); // 1 and 1.0 are the same case
  return true;
}

template <> bool OptionReader::Read(const Option &option, double *value, bool required)
{
  Option one = option;
  std::vector<double> values(1, *value);
  one.most = 1;
  const bool given = Read(one, &values, required);
  *value = values[0];
  return given;
}

template <> bool OptionReader::Read(const Option &option, Vec3 *value, bool required)
{
  Option list = option;
  std::vector<double> values(value->begin(), value->begin() + dim_);
  list.least = list.most = static_cast<std::size_t>(dim_);
  const bool given = Read(list, &values, required);
  std::copy_n(values.begin(), dim_, value->begin());
  return given;
}

bool FindValue(const std::string &name, std::string *value)
{
  std::vector<char> buffer(kLongestValue + 1);
  PetscBool given = PETSC_FALSE;
  ExitOnError(PetscOptionsGetString(nullptr, nullptr, name.c_str(), buffer.data(), buffer.size(), &given));
  *value = buffer.data();
  return given;
}

template <> bool OptionReader::Read(const Option &option, std::vector<std::string> *names, bool required)
{
  std::string text;
  names->clear();
  if (!Read(option, &text, required) && !(learns_ && FindValue(option.name, &text))) {
    if (help_) *names = {"NAME"};
    return false;
  }
  for (const std::string &name : Split(text, ',')) {
    bool valid = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0]));
    for (char c : name) valid = valid && (std::isalnum(static_cast<unsigned char>(c)) || c == '_');
    if (!valid || std::find(names->begin(), names->end(), name) != names->end())
      Refuse(option.name, text, "different names of letters, digits and underscores, separated by commas");
    names->push_back(name);
  }
  return true;
}

int OptionReader::Choice(const Option &option, const std::vector<std::string> &choices, std::string *value)
{
  const std::string all = Join(choices, ", ");
  Raw({option.name, Format("{}: {}", option.help, all), option.unit}, *value, value);
  const auto place = std::find(choices.begin(), choices.end(), *value);
  if (place == choices.end()) Refuse(option.name, value->empty() ? kNothing : *value, "{}", OneOf(*value, choices));
  return static_cast<int>(place - choices.begin());
}

void OptionReader::Viewer(const Option &option)
{
  std::string text;
  PetscViewer viewer;
  if (!Raw(option, "none", &text) || help_) return;
  ExitOnError(PetscOptionsCreateViewer(comm_, nullptr, nullptr, option.name.c_str(), &viewer, nullptr, nullptr));
  ExitOnError(PetscViewerDestroy(&viewer));
}

void OptionReader::Chosen(const std::string &name, double value)
{
  for (std::string &one : identity_)
    if (one.rfind(name + " ", 0) == 0) one = Format("{} {}", name, FormatNumber(value));
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
    Refuse("{}: a blank must be between an option's name and its value, not =", Shortened(option));
  for (const RetiredOption &retired : kRetired)
    if (option == retired.name) Refuse("{}: is not an option any more: {}", option, retired.reason);
  Refuse("{}: unknown or unused option in this case; the nearest known name is {}", Shortened(option), Nearest(option, known));
}

void RefuseUnused(const std::vector<std::string> &known)
{
  for (const std::string &unused : FindUnused()) {
    if (std::find(known.begin(), known.end(), unused) != known.end()) Refuse("{}: is not used in this case", Shortened(unused));
    const bool near = EditDistance(unused, Nearest(unused, known)) <= kMaxTypingErrors;
    if (!near && LooksLikePetsc(unused)) continue;
    if (near || unused.find('=') != std::string::npos) RefuseUnknown(unused, known);
    Refuse("{}: unknown or unused option in this case; another kind of indenter, law, geometry or test has it",
           Shortened(unused));
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

void RefuseMisspelt(std::vector<std::string> all)
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

void WarnUnused(MPI_Comm comm)
{
  // Read by PETSc only when it finishes.
  const std::set<std::string> late = {"-options_left", "-options_view", "-objects_dump",
                                      "-malloc_dump",  "-memory_view",  "-log_view_memory"};
  for (const std::string &unused : FindUnused())
    if (!late.count(unused)) Warn(comm, Format("{}: unused option", Shortened(unused)));
}

} // namespace mlgimp
