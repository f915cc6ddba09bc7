// The types that every part of the importer shares: limits, errors and progress; and what it reads:
// the file formats, and the glTF 2.0 extensions with what it does with each. The importer accepts
// and refuses files by these tables; documents print them.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

using ByteSpan = std::span<const unsigned char>;

struct ImportLimits {
    std::chrono::milliseconds wallClock{60000};
    std::chrono::seconds cpu{60};
    std::uint64_t addressSpaceBytes = 6ull << 30;
    std::uint64_t fileBytes = 512ull << 20;  // of each file; all files together: four times as many
    std::uint64_t maxTriangles = 20'000'000;  // of the meshes; lines and points count, too
    std::uint64_t maxDrawn = 100'000'000;     // the same of all instances together
    std::uint64_t maxNodes = 200'000;
    std::uint64_t maxImagePixels = 64'000'000;
    std::uint64_t maxFiles = 4096;  // read for one scene, or packed in one archive
};

// All limits but wallClock as one line of text, and back. A number that is missing has its default.
std::string encoded(const ImportLimits& limits);
ImportLimits decodedLimits(const std::string& text);

// Faces of an imported environment map that are larger are halved.
inline constexpr std::uint32_t kMaxImportedFace = 1024;  // texels

// Why a file could not be imported. `what()` is for users and contains no path of this machine.
class ImportError : public std::runtime_error {
public:
    enum class Reason { notFound, unsupported, malformed, crashed, timedOut, memory, limit };
    ImportError(Reason reason, const std::string& message)
        : std::runtime_error(message), reason_(reason) {}
    Reason reason() const { return reason_; }

private:
    Reason reason_;
};

std::string_view nameOf(ImportError::Reason reason);  // the enumerator's name

struct ImportProgress {
    std::string stage;      // "reading", "textures", "meshes", "transferring"
    double progress = 0.0;  // 0..1 over all stages
};
using ProgressCallback = std::function<void(const ImportProgress&)>;

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

// Of a file's name: lower case, without the dot; empty without an extension.
std::string lowerExtension(const std::filesystem::path& file);

// Extensions of scenes and archives, lower case, without the dot.
const std::vector<std::string>& importableExtensions();
// The same of one use for messages: ".gltf, .glb, .obj".
std::string extensionsText(FormatUse use);

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
