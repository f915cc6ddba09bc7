// What the importer reads: the file formats, and the glTF 2.0 extensions with what it does with
// each. The importer accepts and refuses files by these tables; documents print them.
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

enum class Support : std::uint8_t {
    drawn,         // read completely
    approximated,  // read in part or converted
    ignored,       // not read; a file that requires it is imported without it
    refused,       // not read; a file that requires it is rejected, others are imported without it
};

struct GltfExtension {
    std::string_view name;
    Support support = Support::refused;
    std::string_view note;  // one sentence
};

// In alphabetical order within each vendor prefix. An extension that is not in the list counts as
// refused.
std::span<const GltfExtension> gltfExtensions();

Support gltfSupport(std::string_view extension);

std::string_view nameOf(Support support);  // the enumerator's name

}  // namespace clerestory
