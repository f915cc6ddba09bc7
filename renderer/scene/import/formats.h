// The file formats that the importer reads. The importer derives its list of extensions from this
// table; documents print it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

enum class FormatUse : std::uint8_t { scene, archive, texture, environment, sidecar };

struct FileFormat {
    FormatUse use = FormatUse::scene;
    std::string_view name;
    // Lower case, with the dot, separated by spaces; the first one is the most common.
    std::string_view extensions;
    std::string_view note;  // what is read and what is not, one or two sentences
};

std::span<const FileFormat> fileFormats();

std::string_view nameOf(FormatUse use);  // the enumerator's name

// Extensions of scenes and archives, lower case, without the dot.
const std::vector<std::string>& importableExtensions();

}  // namespace clerestory
