// Profiles and maps of indenters, as files have them.
#include "program/input/tip_files.hpp"

#include "program/system/agree.hpp"
#include "surface/pieces.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

namespace mlgimp
{

namespace
{

/// The text of a file, which the first rank reads for all.
std::string TextOf(OptionReader &reader, const FileOption &file)
{
  std::string text;
  const std::string problem = OnFirstRank(reader.Comm(), "tip_file", [&]() -> std::string {
    std::ifstream stream(file.path, std::ios::binary);
    if (stream) text.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    return stream && !text.empty() ? "" : "a file that can be read and is not empty";
  });
  if (!problem.empty()) reader.Refuse(file.name, file.path, "{}", problem);
  return ShareText(reader.Comm(), std::move(text));
}

std::string Trimmed(const std::string &text)
{
  const std::size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// Words of a line, parted by commas, semicolons or tabs, or else by blanks. A comma beside another mark is none of these.
std::vector<std::string> WordsOf(const std::string &line)
{
  const bool marked = line.find_first_of(";\t") != std::string::npos, commas = line.find(',') != std::string::npos;
  const char *marks = marked ? ";\t" : commas ? "," : " ";
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(marks, begin), line.size());
    const std::string word = Trimmed(line.substr(begin, end - begin));
    if (!word.empty()) words.push_back(word);
    begin = end + 1;
  }
  return words;
}

/// Rows of numbers of a text; what comes behind a # is left out.
std::vector<std::vector<double>> RowsOf(OptionReader &reader, const FileOption &file, const std::string &text)
{
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::vector<double> row;
    for (const std::string &word : WordsOf(Trimmed(line.substr(0, line.find('#'))))) {
      char *end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      if (*end != 0 || !std::isfinite(value))
        reader.Refuse(file.name, file.path, "rows of numbers with decimal points; line {} has '{}'", number, Shortened(word));
      row.push_back(value);
    }
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

/// The head of a Gwyddion Simple Field by its names, and where its numbers begin.
struct FieldHead {
  std::map<std::string, std::string> values;
  std::size_t data = 0;
  double Number(const std::string &name, double otherwise) const
  {
    const auto found = values.find(name);
    return found == values.end() ? otherwise : std::strtod(found->second.c_str(), nullptr);
  }
};

constexpr char kFieldMagic[] = "Gwyddion Simple Field 1.0\n";

FieldHead HeadOf(const std::string &text)
{
  FieldHead head;
  const std::size_t end = std::min(text.find('\0'), text.size());
  std::istringstream lines(text.substr(0, end));
  std::string line;
  while (std::getline(lines, line))
    if (const std::size_t equals = line.find('='); equals != std::string::npos)
      head.values[Trimmed(line.substr(0, equals))] = Trimmed(line.substr(equals + 1));
  head.data = end + 4 - end % 4; // at least one zero byte, up to a multiple of four
  return head;
}

/// Single precision, in the order of bytes of nearly all machines, rows from the top.
HeightTable FieldOf(OptionReader &reader, const FileOption &file, const std::string &text)
{
  const FieldHead head = HeadOf(text);
  const double columns = head.Number("XRes", 0), rows = head.Number("YRes", 0);
  const double x = head.Number("XReal", 0), y = head.Number("YReal", 0);
  const auto unit = [&](const char *name) { return head.values.count(name) ? head.values.at(name) : ""; };
  if (!(columns >= 4 && rows >= 4 && columns * rows < 1e9 && x > 0 && y > 0))
    reader.Refuse(file.name, file.path, "a field with XRes, YRes >= 4 and XReal, YReal > 0");
  if (unit("XYUnits") != "m" || unit("ZUnits") != "m")
    reader.Refuse(file.name, file.path, "a field of heights with XYUnits = m and ZUnits = m; they are '{}' and '{}'",
                  unit("XYUnits"), unit("ZUnits"));
  HeightTable table{static_cast<int>(columns), static_cast<int>(rows), x / columns, y / rows, {}};
  const std::size_t count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (text.size() != head.data + 4 * count)
    reader.Refuse(file.name, file.path, "{} numbers of 4 bytes behind its head, as XRes and YRes say", count);
  table.heights.resize(count);
  for (int row = 0; row < table.rows; ++row)
    for (int column = 0; column < table.columns; ++column) {
      float value;
      std::memcpy(&value, text.data() + head.data + 4 * (static_cast<std::size_t>(row) * table.columns + column), 4);
      table.At(column, table.rows - 1 - row) = value;
    }
  return table;
}

HeightTable MatrixOf(OptionReader &reader, const FileOption &file, const std::string &text, MapSize size)
{
  const auto rows = RowsOf(reader, file, text);
  if (rows.size() < 4 || rows[0].size() < 4) reader.Refuse(file.name, file.path, "at least 4 rows of 4 numbers");
  if (size.x == 0) reader.Refuse("-indenter_map_size", "", "given with a map of rows of numbers, which does not say its extents");
  const int columns = static_cast<int>(rows[0].size()), count = static_cast<int>(rows.size());
  HeightTable table{columns, count, size.x / columns, size.y / count, {}};
  table.heights.resize(rows.size() * rows[0].size());
  for (int row = 0; row < count; ++row) {
    if (static_cast<int>(rows[row].size()) != columns)
      reader.Refuse(file.name, file.path, "rows of as many numbers; row {} has {}, the first {}", row + 1, rows[row].size(),
                    columns);
    for (int column = 0; column < columns; ++column) table.At(column, count - 1 - row) = rows[row][column];
  }
  return table;
}

} // namespace

ProfileTable ReadProfileFile(OptionReader &reader, const std::string &option, const std::string &path)
{
  const FileOption file{option, path};
  ProfileTable table;
  for (const std::vector<double> &row : RowsOf(reader, file, TextOf(reader, file))) {
    if (row.size() != 2) reader.Refuse(option, path, "two columns; a row has {} numbers", row.size());
    table.distances.push_back(row[0]), table.heights.push_back(row[1]);
  }
  const std::size_t count = table.distances.size();
  if (count < 3) reader.Refuse(option, path, "at least 3 rows");
  if (table.distances[0] != 0 || table.heights[0] != 0) reader.Refuse(option, path, "rows that begin at 0 0, the tip");
  for (std::size_t k = 1; k < count; ++k)
    if (!(table.distances[k] > table.distances[k - 1] && table.heights[k] > table.heights[k - 1]))
      reader.Refuse(option, path, "rows whose distances and heights both grow; row {} does not", k + 1);
  return table;
}

HeightTable ReadMapFile(OptionReader &reader, const FileOption &file, MapSize size)
{
  const std::string text = TextOf(reader, file);
  const bool is_field = text.compare(0, sizeof kFieldMagic - 1, kFieldMagic) == 0;
  if (is_field && size.x > 0)
    reader.Refuse("-indenter_map_size", size.x, "left out with {}, a field that has its extents in its head", file.path);
  HeightTable table = is_field ? FieldOf(reader, file, text) : MatrixOf(reader, file, text, size);
  for (const double height : table.heights)
    if (!std::isfinite(height)) reader.Refuse(file.name, file.path, "heights that are finite numbers");
  if (!(RimHeight(table) > 0))
    reader.Refuse(
        file.name, file.path,
        "the heights of a tip that points down, the lowest inside the map; scripts/tip_map.py turns an image of one that "
        "points up");
  const double reach = 0.5 * std::max(table.columns * table.dx, table.rows * table.dy), rim = RimHeight(table);
  if (kMinFacing * rim > reach)
    reader.Refuse(
        file.name, file.path,
        "heights that rise by less than ten times their distance from the lowest; they rise by {} m within {} m: are both in m?",
        rim, reach);
  return table;
}

} // namespace mlgimp
