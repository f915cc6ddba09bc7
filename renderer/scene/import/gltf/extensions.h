// The glTF 2.0 extensions that the importer knows, with what it does with each. The importer reads
// this list to accept or refuse a file; documents print it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace clerestory {

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
