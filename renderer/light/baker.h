// Computes the light of scenes in the background, on threads of low priority that rest while frames
// are drawn.
//
//     Baker baker;
//     baker.begin(key, [=] { return std::make_unique<Bake>(input, BakeQuality{}); });
//     if (const auto light = baker.latest(key)) draw(*light);
//
// All members may be called from any thread.
#pragma once

#include "light/bake.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace clerestory::light {

struct BakerOptions {
    std::uint32_t threads = 0;  // 0: one for each processor
    bool background = true;     // with low priority
    // Lights in memory, finished and not; the least recently used of each are dropped first.
    std::size_t kept = 4, waiting = 16;
    // Called on a thread of the baker for each light that it has computed.
    std::function<void(const SurfaceLight&)> whenComplete;
    // Likewise for each that it could not compute, with the reason.
    std::function<void(const std::string&)> whenFailed;
};

class Baker {
public:
    explicit Baker(const BakerOptions& options = {});
    // Cancels the work in progress.
    ~Baker();
    Baker(const Baker&) = delete;
    Baker& operator=(const Baker&) = delete;

    using Make = std::function<std::unique_ptr<Bake>()>;
    // Begins to compute, unless the key is known. `make` is called on a thread of the baker. The
    // light that was begun last is computed first.
    void begin(std::uint64_t key, Make make);
    // Keeps complete light that was computed before, unless its key is known.
    void keep(std::shared_ptr<const SurfaceLight> light);
    // The light of the last round that is complete; null before the first one.
    std::shared_ptr<const SurfaceLight> latest(std::uint64_t key);

    struct State {
        bool known = false, complete = false;
        double share = 0.0;
        std::string failure;  // why it was not computed; else empty
    };
    State state(std::uint64_t key) const;
    // Waits until the light is complete or has failed, or `abandoned` returns true. `abandoned` is
    // called at least about every 20 ms. The calling thread takes part in the computation, with its
    // own priority: what a caller waits for does not stay behind other processes.
    State wait(std::uint64_t key, const std::function<bool()>& abandoned = {});
    // Drops the lights of a scene.
    void forget(const Scene& scene);

    // While one exists the threads rest.
    class Rest {
    public:
        explicit Rest(Baker& baker);
        ~Rest();
        Rest(const Rest&) = delete;
        Rest& operator=(const Rest&) = delete;

    private:
        Baker& baker_;
    };

private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

}  // namespace clerestory::light
