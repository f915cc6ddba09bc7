// Lights on disk, next to imported scenes, so that a restart does not compute them again.
//
//     LightFiles files({.folder = folder, .version = "1.2"});
//     if (auto light = files.find(key, refine)) return *light;
//     ... files.store(light);
//
// Thread-safe.
#pragma once

#include "light/surface_light.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace clerestory::light {

struct LightFilesOptions {
    std::filesystem::path folder;  // empty: nothing is stored
    std::uint64_t maxBytes = 1ull << 30;
    std::string version;  // of the program; files of other versions are not used
    // Called with one line for the log when the first of several writes fails.
    std::function<void(const std::string&)> reportFailure;
};

class LightFiles {
public:
    explicit LightFiles(LightFilesOptions options) : options_(std::move(options)) {}

    // Makes the refined scene that the light was computed for.
    using Refine = std::function<std::shared_ptr<const Scene>(const EdgeLengths& edges)>;
    // The complete light of this key. Nothing if there is no file, or if it is damaged or does not
    // belong to the refined scene.
    std::optional<SurfaceLight> find(std::uint64_t key, const Refine& refine) const;
    // Only complete light. The least recently used files are removed to make room.
    void store(const SurfaceLight& light);

private:
    std::filesystem::path fileOf(std::uint64_t key) const;

    const LightFilesOptions options_;
    std::atomic<bool> failureReported_{false};
};

}  // namespace clerestory::light
