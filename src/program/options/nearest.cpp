// What a misspelt name may have meant.
#include "program/options/nearest.hpp"

#include "program/options/options.hpp"

#include <algorithm>
#include <numeric>

namespace mlgimp
{

std::size_t EditDistance(const std::string &a, const std::string &b)
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

const std::string &Nearest(const std::string &name, const std::vector<std::string> &known)
{
  const auto distance = [&](const std::string &one) { // or that of its beginning, where not even that is a name
    return std::min(EditDistance(name, one), EditDistance(name, one.substr(0, name.size())) + kMaxTypingErrors);
  };
  return *std::min_element(known.begin(), known.end(), [&](const auto &a, const auto &b) { return distance(a) < distance(b); });
}

std::string Meant(const std::string &name, const std::vector<std::string> &known)
{
  constexpr std::size_t kLettersOfError = 3; // size: of messages alone; so many letters of a name may have one wrong
  const std::string small = LowerCase(name);
  const std::size_t allowed = std::min(kMaxTypingErrors, small.size() / kLettersOfError);
  std::string best;
  std::size_t least = allowed + 1;
  for (const std::string &one : known)
    if (const std::size_t errors = EditDistance(small, LowerCase(one)); errors < least) best = one, least = errors;
  if (!best.empty() || small.size() < kLettersOfError) return best;
  for (const std::string &one : known)
    if (EditDistance(small, LowerCase(one).substr(0, small.size())) < std::max<std::size_t>(allowed, 1)) return one;
  return "";
}

std::string OneOf(const std::string &name, const std::vector<std::string> &known)
{
  const std::string meant = Meant(name, known), all = Join(known, ", ");
  return meant.empty() ? Format("one of {}", all) : Format("{}, which is nearest, or another of {}", meant, all);
}

} // namespace mlgimp
