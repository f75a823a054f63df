// Option reading on PETSc's options database.
#include "program/options.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>
#include <set>
#include <sstream>

namespace mlgimp
{

static constexpr std::size_t kLongestValue = 65535; ///< characters

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

std::string FormatVector(Vec2 x) { return FormatNumber(x[0]) + "," + FormatNumber(x[1]); }

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

PetscErrorCode OptionReader::Vector(const OptionText &option, bool required, Vec2 *value, bool *given)
{
  std::vector<double> values = {(*value)[0], (*value)[1]};
  PetscFunctionBeginUser;
  PetscCall(Numbers(option, kAnyNumber, 2, 2, required, &values, given));
  *value = {values[0], values[1]};
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

PetscErrorCode OptionReader::RefuseUnused() const
{
  // Read by PETSc only when it finishes.
  const std::set<std::string> late = {"options_left", "objects_dump", "malloc_dump", "memory_view", "log_view_memory"};
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  std::string unused;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  for (PetscInt k = 0; k < count && unused.empty(); ++k)
    if (!late.count(names[k])) unused = names[k];
  PetscCall(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  if (unused.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  unused = "-" + unused;
  if (std::find(known_.begin(), known_.end(), unused) != known_.end())
    SETERRQ(comm_, PETSC_ERR_USER_INPUT, "%s: is not used in this case", Shortened(unused).c_str());
  const auto nearest = std::min_element(known_.begin(), known_.end(), [&](const auto &a, const auto &b) {
    return EditDistance(unused, a) < EditDistance(unused, b);
  });
  SETERRQ(comm_, PETSC_ERR_USER_INPUT, "%s: nothing reads this option in this case; the nearest known name is %s",
          Shortened(unused).c_str(), nearest->c_str());
}

namespace
{

bool IsOptionName(const std::string &word)
{
  return word.size() > 1 && word[0] == '-' && (std::isalpha(static_cast<unsigned char>(word[1])) || word[1] == '-');
}

/// The text with a question mark for each character that is none.
std::string Printable(std::string text)
{
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return !std::isprint(c); }, '?');
  return text;
}

std::string CheckOptionsFile(const std::string &path)
{
  if (path.size() > 5 && path.substr(path.size() - 5) == ".yaml")
    return "-options_file " + path + ": must hold lines '-name value'; YAML is not read";
  std::ifstream file(path);
  if (!file || file.peek() == std::ifstream::traits_type::eof())
    return "-options_file " + path + ": must be a readable file with options";
  std::set<std::string> seen;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    line = line.substr(0, line.find('#'));
    std::istringstream words(line);
    std::string name, value, more;
    words >> name >> value >> more;
    const std::string place = "-options_file " + path + ": line " + std::to_string(number) + ": ";
    if (std::any_of(line.begin(), line.end(), [](unsigned char c) { return std::iscntrl(c) && !std::isspace(c); }))
      return place + "must be text, found '" + Shortened(Printable(line)) + "'";
    if (name.size() + value.size() > kLongestValue)
      return place + "must not be longer than " + std::to_string(kLongestValue) + " characters";
    if (name.empty()) continue;
    if (!IsOptionName(name)) return place + "must be '-name value', found '" + Shortened(Printable(name)) + "'";
    if (name == "-options_file") return place + "must not name another options file; give both on the command line";
    if (!more.empty()) return place + "must be '-name value' with no blanks in the value, found '" + Shortened(more) + "'";
    if (!seen.insert(name).second)
      return name + " " + Shortened(value) + ": must be given once, found again in line " + std::to_string(number) + " of " +
             path;
  }
  return "";
}

} // namespace

std::string CheckCommandLine(int argc, char **argv)
{
  std::set<std::string> seen;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word.size() > kLongestValue)
      return "'" + Shortened(word) + "': must not be longer than " + std::to_string(kLongestValue) + " characters";
    const bool after_option = k > 1 && IsOptionName(argv[k - 1]);
    if (!IsOptionName(word)) {
      if (!after_option) return "'" + word + "': must follow an option that takes it; options begin with a dash";
      continue;
    }
    if (word == "-options_file") {
      const std::string path = k + 1 < argc ? argv[k + 1] : "";
      std::string message = CheckOptionsFile(path);
      if (!message.empty()) return message;
    } else if (!seen.insert(word).second) {
      return word + ": must be given once on the command line";
    }
  }
  return "";
}

} // namespace mlgimp
