// The light of surfaces (Effects::indirectLight) as users of the renderer see it: how finely it is
// computed, and how far the computation is. Until it is complete a frame shows that of the rounds
// so far, at first that of an environment that nothing hides.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace clerestory {

// How finely the light is computed.
struct LightOptions {
    std::uint32_t threads = 0;              // 0: one for each processor
    bool background = true;                 // with low priority: frames do not wait for it
    std::uint64_t addedTriangles = 12'000;  // at most, to a scene whose triangles are large
    std::uint32_t places = 60'000;          // at most, where light is gathered
    // Where complete light is stored for the next start; empty: nowhere.
    std::filesystem::path folder;
    std::uint64_t folderBytes = 1ull << 30;
    std::string version;  // of the program; light of other versions is not used
    // Called with one line for the log when light cannot be computed or stored.
    std::function<void(const std::string&)> reportFailure;
    // Called on a thread of the computation at its beginning, with the id of the scene. The result
    // is kept until its end; if it is null, the light is not computed, which is a failure.
    std::function<std::shared_ptr<const void>(const std::string& scene)> begin;
};

struct LightState {
    bool wanted = false;  // requested, for a scene that has such light
    bool complete = false;
    std::uint32_t revision = 0;  // of what a frame would show now; 0: none yet
    double share = 0.0;          // computed, 0..1
    std::string failure;         // why it cannot be computed; else empty
    // Waits on any thread until the light is complete or has failed, or `abandoned` returns true;
    // empty if the request needs none.
    std::function<void(const std::function<bool()>& abandoned)> wait = {};
};

}  // namespace clerestory
