#include "scene/import/base/clean_text.h"

#include <algorithm>
#include <cstddef>

namespace clerestory {
namespace {

constexpr std::size_t kMaxTextBytes = 200;

// The length of the UTF-8 sequence at `at`; 0 if it is invalid (RFC 3629).
std::size_t sequenceLength(const std::string& text, std::size_t at) {
    const auto byte = [&](std::size_t i) -> unsigned {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const auto follows = [&](std::size_t n) {
        for (std::size_t i = 1; i <= n; ++i) {
            if ((byte(at + i) & 0xC0u) != 0x80u) return false;
        }
        return true;
    };
    const unsigned first = byte(at);
    const unsigned second = byte(at + 1);
    if (first < 0x80) return 1;
    if (first >= 0xC2 && first <= 0xDF) return follows(1) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF) {
        const bool overlong = first == 0xE0 && second < 0xA0;
        const bool surrogate = first == 0xED && second >= 0xA0;
        return follows(2) && !overlong && !surrogate ? 3 : 0;
    }
    if (first >= 0xF0 && first <= 0xF4) {
        const bool overlong = first == 0xF0 && second < 0x90;
        const bool tooLarge = first == 0xF4 && second >= 0x90;
        return follows(3) && !overlong && !tooLarge ? 4 : 0;
    }
    return 0;
}

}  // namespace

std::string cleanText(const std::string& text) {
    std::string clean;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = sequenceLength(text, i);
        if (clean.size() + std::max<std::size_t>(length, 1) > kMaxTextBytes) {
            break;
        }
        const bool control =
            length == 1 && (static_cast<unsigned char>(text[i]) < 0x20 || text[i] == 0x7f);
        clean += length == 0 || control ? "?" : text.substr(i, length);
        i += std::max<std::size_t>(length, 1);
    }
    return clean;
}

}  // namespace clerestory
