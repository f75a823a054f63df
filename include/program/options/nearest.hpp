// What a misspelt name may have meant: the known one that is most like it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace mlgimp
{

constexpr std::size_t kMaxTypingErrors = 2; ///< size: of messages alone; between a name and the one that was meant

/// Number of insertions, deletions and replacements that turn a into b (Levenshtein).
std::size_t EditDistance(const std::string &a, const std::string &b);

/// The known name that is most like another; known: at least one.
const std::string &Nearest(const std::string &name, const std::vector<std::string> &known);

/// The known name that was probably meant: the same but for capitals, a few letters, or an end that was left out; empty where
/// there is none.
std::string Meant(const std::string &name, const std::vector<std::string> &known);

/// What a choice must be, as messages have it: "one of a, b", with the name that was probably meant before them.
std::string OneOf(const std::string &name, const std::vector<std::string> &known);

} // namespace mlgimp
