// Checks the command line and options files before PETSc reads them, which ends with a trace where it cannot parse them.
#include "program/options/command_line.hpp"

#include "program/options/options.hpp"
#include "program/options/units.hpp"
#include "program/system/agree.hpp"
#include "program/system/files.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <poll.h>
#include <set>
#include <sstream>
#include <unistd.h>

namespace mlgimp
{

namespace fs = std::filesystem;

namespace
{

constexpr std::size_t kMaxOptions = 512; ///< size: names that PETSc's table holds, in some of its versions

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

/// All of a file or pipe; false where it cannot be read, or nothing comes for some seconds.
bool ReadAll(const std::string &path, std::string *text)
{
  constexpr int kTimeout = 5000;               // size: ms
  constexpr std::size_t kMaxBytes = 100000000; // size
  char buffer[1 << 16];
  Descriptor file(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC), close); // a pipe without a writer would be waited for
  while (file.Valid() && text->size() < kMaxBytes) {
    pollfd ready{file, POLLIN, 0};
    if (poll(&ready, 1, kTimeout) == 0) return false;
    const ssize_t count = read(file, buffer, sizeof buffer);
    if (count > 0) text->append(buffer, static_cast<std::size_t>(count));
    if (count == 0) return true;
    if (count < 0 && errno != EAGAIN && errno != EINTR) return false;
  }
  return false;
}

/// What is wrong with the characters of a line.
std::string WrongCharacters(const std::string &line)
{
  if (line.rfind("\xef\xbb\xbf", 0) == 0) return "must be text without a byte-order mark; save the file as plain UTF-8";
  if (line.find("\xc2\xa0") != std::string::npos)
    return Format("must have plain blanks, found a no-break space in '{}'", Shortened(Printable(line)));
  if (std::any_of(line.begin(), line.end(), [](unsigned char c) { return std::iscntrl(c) && !std::isspace(c); }))
    return Format("must be text, found '{}'", Shortened(Printable(line)));
  return "";
}

/// Whether a word is the unit of the numbers that the word before it ends with, as in "200 nm".
bool IsUnitOf(const std::string &value, const std::string &word)
{
  const bool ends_in_number = !value.empty() && (std::isdigit(static_cast<unsigned char>(value.back())) || value.back() == '.');
  return ends_in_number && !word.empty() && !std::isdigit(static_cast<unsigned char>(word[0])) && ParseUnit(word);
}

/// Adds the options of a file to the words; returns what is wrong, or an empty string.
std::string ReadOptionsFile(const std::string &path, std::vector<std::string> *options)
{
  std::string text, line;
  std::set<std::string> seen;
  if (path.size() > 5 && path.substr(path.size() - 5) == ".yaml")
    return Format("-options_file {}: must hold lines '-name value'; YAML is not read", path);
  if (!ReadAll(path, &text) || text.empty()) return Format("-options_file {}: must be a readable file with options", path);
  std::istringstream lines(text);
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string place = Format("-options_file {}: line {}: ", path, number);
    if (const std::size_t end = line.find('\r'); end != std::string::npos && end + 1 < line.size())
      return Format("{}must end in a line feed; a carriage return alone ends no line", place);
    line = line.substr(0, line.find('#'));
    std::istringstream words(line);
    std::string name, value, more, further;
    words >> name >> value >> more >> further;
    if (further.empty() && IsUnitOf(value, more)) {
      value += more;
      more.clear();
    }
    const std::string wrong = WrongCharacters(line);
    if (!wrong.empty()) return Format("{}{}", place, wrong);
    if (name.size() + value.size() > kLongestValue)
      return Format("{}must not be longer than {} characters", place, kLongestValue);
    if (name.empty()) continue;
    if (!IsOptionName(name)) return Format("{}must be '-name value', found '{}'", place, Shortened(Printable(name)));
    if (LowerCase(name) == "-options_file")
      return Format("{}must not name another options file; give both on the command line", place);
    if (!more.empty()) return Format("{}must be '-name value' with no blanks in the value, found '{}'", place, Shortened(more));
    if (IsOptionName(value))
      return Format("{}must be '-name value', found the name of an option as the value '{}'", place, Shortened(value));
    if (!seen.insert(LowerCase(name)).second)
      return Format("{} {}: must be given once, found again in line {} of {} (capitals make no difference)", name,
                    Shortened(value), number, path);
    options->push_back(name);
    if (!value.empty()) options->push_back(value);
  }
  return "";
}

std::string NameOf(std::string path)
{
  path = path.substr(path.find_last_of('/') + 1);
  path = path.substr(0, path.find_last_of('.'));
  return path.empty() ? "run" : path;
}

/// The first rank's part of ReadCommandLine; returns what is wrong.
std::string Parse(int argc, char **argv, CommandLine *line)
{
  std::map<std::string, std::string> spelt; // on the command line, by lower case
  std::set<std::string> names;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word.size() > kLongestValue) return Format("'{}': must not be longer than {} characters", Shortened(word), kLongestValue);
    if (LowerCase(word) == "-options_file") {
      const std::string path = ++k < argc ? argv[k] : "";
      if (std::string wrong = ReadOptionsFile(path, &line->words); !wrong.empty()) return wrong;
      line->name = NameOf(path);
      continue;
    }
    if (k > 2 && IsOptionName(argv[k - 2]) && IsUnitOf(argv[k - 1], word)) {
      line->words.back() += word;
      continue;
    }
    if (!IsOptionName(word) && (k == 1 || !IsOptionName(argv[k - 1])))
      return Format("'{}': must follow an option that takes it; options begin with a dash{}", word,
                    access(word.c_str(), R_OK) == 0 ? ", and a file of options follows -options_file" : "");
    if (IsOptionName(word))
      if (const auto known = spelt.emplace(LowerCase(word), word).first; known->second != word)
        return Format("{}: must be spelt as {}, which is given too: capitals make no difference", word, known->second);
    line->words.push_back(word);
  }
  for (const std::string &word : line->words)
    if (IsOptionName(word)) names.insert(LowerCase(word));
  if (names.size() > kMaxOptions)
    return Format("{} options: must be at most {}, as many as PETSc takes; polygons need fewer than boxes", names.size(),
                  kMaxOptions);
  return "";
}

/// Takes words of these, without a value, out of the others; whether one was there.
bool Take(const std::set<std::string> &names, std::vector<std::string> *words)
{
  const std::size_t before = words->size();
  for (std::size_t k = words->size(); k-- > 0;)
    if (names.count((*words)[k]) && (k + 1 == words->size() || IsOptionName((*words)[k + 1]))) words->erase(words->begin() + k);
  return words->size() < before;
}

} // namespace

/// The folder with cases and documents that belongs to this program, as installed or as built; empty where there is none.
static fs::path FindShare()
{
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (fs::path folder = program.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    for (const fs::path &share : {folder / "share" / "mlgimp", folder})
      if (fs::exists(share / "options" / "wedge_500nm.opts", error)) return share;
  return {};
}

/// A file of that folder, as seen from here; its name alone where there is no such folder.
static std::string InShare(const fs::path &file)
{
  std::error_code error;
  const fs::path share = FindShare(), near = (share / file).lexically_proximate(fs::current_path(error));
  if (share.empty()) return file.filename();
  return near.begin()->string() == ".." ? share / file : near;
}

std::string Usage(const std::string &program)
{
  return Format("a first case, with results in output/:   {} -options_file {}\nevery option with its unit and default:  {} "
                "-help\nfrom there to a case of your own:        {}\n",
                program, InShare("options/wedge_500nm.opts"), program, InShare("docs/tutorial.md"));
}

std::string HelpHead(const std::string &program)
{
  const std::string command = Format("{} -options_file {}", program, InShare("options/NAME.opts"));
  return Format("mlgimp: explicit GIMP simulation of indentation and contact.\n\n  {} [-option value ...]\n  mpiexec -n N {}\n\n",
                command, command);
}

CommandLine ReadCommandLine(int argc, char **argv)
{
  CommandLine line;
  line.name = "run";
  if (RankIn(MPI_COMM_WORLD) == 0) line.problem = Parse(argc, argv, &line);
  const std::string words = ShareText(MPI_COMM_WORLD, Join(line.words, std::string(1, '\0')));
  line.name = ShareText(MPI_COMM_WORLD, line.name);
  line.problem = ShareText(MPI_COMM_WORLD, line.problem);
  line.words = words.empty() ? std::vector<std::string>() : Split(words, '\0');
  line.help = Take({"-help", "--help", "-h"}, &line.words);
  line.presets = Take({"-presets", "--presets"}, &line.words);
  line.version = Take({"-version", "--version"}, &line.words);
  return line;
}

} // namespace mlgimp
