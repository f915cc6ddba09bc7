// The types that every part of the importer shares: limits, errors, progress.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace clerestory {

struct ImportLimits {
    std::chrono::milliseconds wallClock{60000};
    std::chrono::seconds cpu{60};
    std::uint64_t addressSpaceBytes = 6ull << 30;
    std::uint64_t fileBytes = 512ull << 20;  // of each file; all files together: four times as many
    std::uint64_t maxTriangles = 20'000'000;
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
    std::string stage;      // "reading", "textures", "meshes", "handing over"
    double progress = 0.0;  // 0..1 over all stages
};
using ProgressCallback = std::function<void(const ImportProgress&)>;

}  // namespace clerestory
