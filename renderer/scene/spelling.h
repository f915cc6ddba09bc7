// Suggestions for misspelt names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// The candidate with the smallest edit distance (insert, delete, replace, transpose; ignores case),
// or an empty view if none is close.
std::string_view nearestWord(std::string_view word,
                             const std::vector<std::string_view>& candidates);

// `; did you mean "..."?` or an empty text, to be appended to a message about an unknown name.
std::string didYouMean(std::string_view word, const std::vector<std::string_view>& candidates);

// "a, b, c"
std::string listed(const std::vector<std::string_view>& words);

// The same; of many words only the closest ones and the number of others.
std::string listedNearest(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace clerestory
