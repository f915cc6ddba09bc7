// The light between surfaces of a renderer's scenes: requests begin it, threads compute it in the
// background, and it is kept in memory and on disk.
#pragma once

#include "light/baker.h"
#include "light/light_files.h"
#include "light/open_light.h"
#include "light/refinement.h"
#include "light_state.h"
#include "plan/graph/light_progress.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace clerestory {

class SceneLights {
public:
    explicit SceneLights(const LightOptions& options);

    // Whether the light was begun or found.
    bool known(std::uint64_t key) const { return baker_->state(key).known; }
    // Reads the light of an original scene with this key, which is complete then. Returns false if
    // it is not stored on disk. pose: with materials at rest.
    bool find(const Scene& original, const Pose& pose, std::uint64_t key);
    // Begins to compute it. input: everything but the refined scene.
    void begin(const std::shared_ptr<const Scene>& original, light::BakeInput input);
    // Of the last round that is complete; null before the first one.
    std::shared_ptr<const light::SurfaceLight> latest(std::uint64_t key);
    // What is shown before the first one.
    std::shared_ptr<const light::SurfaceLight> open(const light::OpenLightInput& input);
    // Frees that of a scene that is not shown, or whose light has been computed since.
    void releaseOpen(const std::function<bool(const Scene&)>& isShown);
    LightState state(std::uint64_t key) const;
    // See Frame::lightNow.
    std::function<LightProgress()> now(std::uint64_t key) const;

    // Frames of the original scene show this refined one, which forget() returns.
    void addShown(const Scene& original, const std::shared_ptr<const Scene>& refined);
    // The original scenes of which frames show a refined one.
    std::vector<const Scene*> replaced() const;
    // Forgets the lights of an original scene. Returns its refined scenes that were shown. Another
    // original with the same light may show them, too, and uploads them again.
    std::vector<std::shared_ptr<const Scene>> forget(const Scene& original);
    // The same for originals with light from disk only of which no refined scene is shown.
    std::vector<std::shared_ptr<const Scene>> releaseStored(
        const std::function<bool(const Scene&)>& isShown);

    std::uint64_t computed() const { return *computed_; }

    // While it exists the threads rest.
    light::Baker::Rest rest() const { return light::Baker::Rest(*baker_); }

private:
    // The refined meshes of a scene, made by the first computation of its light, or as the first
    // one that is stored on disk needs them.
    struct Refined {
        std::mutex making;
        // With that lock held:
        std::shared_ptr<const Scene> scene;
        light::EdgeLengths edges;
        // On the renderer's thread:
        std::vector<std::shared_ptr<const Scene>> shown;  // an earlier load may have made others
        bool onDisk = false;                              // all lights of the scene
    };

    const std::shared_ptr<Refined>& entryOf(const Scene& original);
    static void keep(Refined& entry, light::Refined made);

    const LightOptions options_;
    const std::shared_ptr<std::atomic<std::uint64_t>> computed_;
    const std::shared_ptr<light::LightFiles> files_;
    const std::shared_ptr<light::Baker> baker_;                 // clients that wait share it
    std::map<const Scene*, std::shared_ptr<Refined>> refined_;  // by their originals
    std::shared_ptr<const light::SurfaceLight> open_;           // the last one, while it is shown
};

}  // namespace clerestory
