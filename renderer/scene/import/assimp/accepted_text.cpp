#include "scene/import/assimp/accepted_text.h"

#include <algorithm>
#include <cstdint>

namespace clerestory {
namespace {

constexpr std::string_view kBlank = " \t";

// Lines from their first word on. Assimp passes over indented vertices.
std::string withoutIndentation(std::string_view text) {
    std::string result;
    result.reserve(text.size());
    for (std::size_t at = 0; at < text.size();) {
        at = std::min(text.find_first_not_of(kBlank, at), text.size());
        const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
        if (at < end) result.append(text, at, end - at);
        at = std::max(at, end);
    }
    return result;
}

// What an OBJ file declares, up to its first element.
struct ObjContent {
    std::uint64_t vertices = 0, normals = 0;
    bool hasElements = false;
};

ObjContent contentOf(std::string_view text) {
    ObjContent content;
    for (std::size_t at = 0; at < text.size() && !content.hasElements;) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = text.substr(at, end - at);
        const std::string_view word = line.substr(0, line.find_first_of(kBlank));
        content.vertices += word == "v" ? 1 : 0;
        content.normals += word == "vn" ? 1 : 0;
        content.hasElements = word == "f" || word == "l" || word == "p";
        at = end + 1;
    }
    return content;
}

// A tag with the text before it. Assimp passes over cameras and lights without a name.
std::string namedTag(std::string_view tag) {
    std::string text(tag);
    const std::size_t opened = text.rfind('<');
    const bool named =
        opened != std::string::npos && text.find(" name=", opened) != std::string::npos;
    for (const std::string_view element : {"<camera ", "<light "}) {
        if (opened == std::string::npos || named) break;
        if (text.compare(opened, element.size(), element) == 0) {
            text.insert(opened + element.size(), "name=\"\" ");
        }
    }
    return text;
}

// Assimp takes xfov where both angles are given, and yfov only with an aspect ratio: a vertical
// angle without one gets that of a square, and is then the only angle.
void keepVerticalAngles(std::string& xml) {
    constexpr std::string_view kBegin = "<perspective>", kEnd = "</perspective>";
    for (std::size_t at = xml.find(kBegin); at != std::string::npos; at = xml.find(kBegin, at)) {
        at += kBegin.size();
        const std::size_t end = xml.find(kEnd, at);
        if (end == std::string::npos) break;
        std::string lens = xml.substr(at, end - at);
        if (lens.find("<yfov") == std::string::npos ||
            lens.find("<aspect_ratio") != std::string::npos) {
            continue;
        }
        const std::size_t first = lens.find("<xfov"), last = lens.find("</xfov>");
        if (first < last && last != std::string::npos) {
            lens.erase(first, last + std::string_view("</xfov>").size() - first);
        }
        xml.replace(at, end - at, lens + "<aspect_ratio>1</aspect_ratio>");
    }
}

}  // namespace

std::string acceptedCollada(std::string_view xml) {
    constexpr std::string_view kSpaces = " \t\r\n", kNumber = "+-.0123456789";
    std::string text;
    text.reserve(xml.size());
    for (std::size_t at = 0; at < xml.size();) {
        const std::size_t end = std::min(xml.find('>', at), xml.size() - 1) + 1;
        text += namedTag(xml.substr(at, end - at));
        const std::size_t first = std::min(xml.find_first_not_of(kSpaces, end), xml.size());
        const bool number =
            first < xml.size() && kNumber.find(xml[first]) != std::string_view::npos;
        at = number ? first : end;
    }
    keepVerticalAngles(text);
    return text;
}

std::string acceptedObj(std::string_view obj) {
    constexpr std::uint64_t kPerLine = 64;  // Assimp's lines are limited
    std::string text = withoutIndentation(obj);
    const ObjContent content = contentOf(text);
    if (content.hasElements || content.vertices == 0) return text;
    for (std::uint64_t i = 1; i <= content.vertices; ++i) {
        text += i % kPerLine == 1 ? "\np " : " ";
        const std::string number = std::to_string(i);
        text += number;
        if (content.normals == content.vertices) text += "//" + number;
    }
    return text + "\n";
}

}  // namespace clerestory
