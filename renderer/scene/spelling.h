// Suggestions for misspelt names.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// The names of things that have one, sorted, each once.
template <class Named>
std::vector<std::string_view> namesOf(const std::vector<Named>& things) {
    std::vector<std::string_view> names;
    for (const Named& thing : things) {
        if (!thing.name.empty()) names.push_back(thing.name);
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

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
