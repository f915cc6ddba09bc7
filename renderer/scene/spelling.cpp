#include "scene/spelling.h"

#include <algorithm>
#include <cctype>

namespace clerestory {
namespace {

// Longer words are not compared: the time is the product of the lengths.
constexpr std::size_t kMaxWordLength = 64;
// Longer lists are not compared: a scene may have 200 000 names.
constexpr std::size_t kMaxCandidates = 2000;

std::size_t distance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    const auto same = [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) ==
               std::tolower(static_cast<unsigned char>(y));
    };
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                d[i][j] = i + j;
                continue;
            }
            const bool equal = same(a[i - 1], b[j - 1]);
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + !equal});
            if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1])) {
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
            }
        }
    }
    return d[a.size()][b.size()];
}

}  // namespace

std::string_view nearestWord(std::string_view word,
                             const std::vector<std::string_view>& candidates) {
    if (word.size() > kMaxWordLength) return {};
    std::string_view best;
    // Up to a third of the letters may differ: "positon", "fov" for "yfov", but not "a" for "up".
    std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (std::size_t i = 0; i < std::min(candidates.size(), kMaxCandidates); ++i) {
        const std::string_view candidate = candidates[i];
        if (candidate.size() > kMaxWordLength) continue;
        const std::size_t d = distance(word, candidate);
        if (d < least && d < candidate.size()) {
            least = d;
            best = candidate;
        }
    }
    return best;
}

std::string didYouMean(std::string_view word, const std::vector<std::string_view>& candidates) {
    const std::string_view near = nearestWord(word, candidates);
    return near.empty() ? "" : "; did you mean \"" + std::string(near) + "\"?";
}

std::string listed(const std::vector<std::string_view>& words) {
    std::string text;
    for (const std::string_view word : words)
        text += (text.empty() ? "" : ", ") + std::string(word);
    return text;
}

std::string listedNearest(std::string_view word, const std::vector<std::string_view>& words) {
    constexpr std::size_t kMaxListed = 8;
    if (words.size() <= kMaxListed) return listed(words);
    std::vector<std::pair<std::size_t, std::string_view>> near;
    word = word.substr(0, kMaxWordLength);
    for (std::size_t i = 0; i < std::min(words.size(), kMaxCandidates); ++i) {
        near.emplace_back(distance(word, words[i].substr(0, kMaxWordLength)), words[i]);
    }
    const auto end = near.begin() + kMaxListed;
    std::partial_sort(near.begin(), end, near.end());
    std::string text;
    for (auto it = near.begin(); it != end; ++it) {
        text += (text.empty() ? "" : ", ") + std::string(it->second);
    }
    return text + " and " + std::to_string(words.size() - kMaxListed) + " more";
}

}  // namespace clerestory
