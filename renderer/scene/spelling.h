// The word somebody probably meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// The nearest candidate by edit distance (insert, delete, replace, swap neighbours; case does not
// count), or nothing when none is near.
std::string_view nearestWord(std::string_view word,
                             const std::vector<std::string_view>& candidates);

// `; did you mean "..."?` or nothing: the end of a sentence about a word that is not known.
std::string didYouMean(std::string_view word, const std::vector<std::string_view>& candidates);

// "a, b, c"
std::string listed(const std::vector<std::string_view>& words);

// The same, but of many words only the few nearest, and how many more there are.
std::string listedNearest(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace clerestory
