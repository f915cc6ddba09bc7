#include "scene_lights.h"

#include "gl/buffer.h"
#include "light/division.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace clerestory {
namespace {

// What the light depends on besides its key.
std::string versionOf(const LightOptions& options) {
    return options.version + '\n' + std::to_string(options.addedTriangles) + ' ' +
           std::to_string(options.places);
}

}  // namespace

SceneLights::SceneLights(const LightOptions& options)
    : options_(options),
      computed_(std::make_shared<std::atomic<std::uint64_t>>(0)),
      files_(std::make_shared<light::LightFiles>(
          light::LightFilesOptions{.folder = options.folder,
                                   .maxBytes = options.folderBytes,
                                   .version = versionOf(options),
                                   .reportFailure = options.reportFailure})),
      baker_(std::make_shared<light::Baker>(light::BakerOptions{
          .threads = options.threads,
          .background = options.background,
          .whenComplete =
              [files = files_, computed = computed_](const light::SurfaceLight& light) {
                  ++*computed;
                  files->store(light);
              },
          .whenFailed =
              [report = options.reportFailure](const std::string& reason) {
                  if (report) report("Light cannot be computed: " + reason);
              }})) {}

// With the lock of its entry held.
void SceneLights::keep(Refined& entry, light::Refined made) {
    gl::fitForSharing(made.scene.vertices);
    gl::fitForSharing(made.scene.indices);
    entry.edges = std::move(made.edges);
    entry.scene = std::make_shared<const Scene>(std::move(made.scene));
}

const std::shared_ptr<SceneLights::Refined>& SceneLights::entryOf(const Scene& original) {
    std::shared_ptr<Refined>& entry = refined_[&original];
    if (!entry) entry = std::make_shared<Refined>();
    return entry;
}

// Read here, not by the baker: its threads may be busy, or rest because a frame is drawn.
bool SceneLights::find(const Scene& original, const Pose& pose, std::uint64_t key) {
    Refined& entry = *entryOf(original);
    std::shared_ptr<const Scene> made;
    // Only light that is there waits for a thread that refines the scene.
    auto stored = files_->find(key, [&](const light::EdgeLengths& edges) {
        const std::lock_guard lock(entry.making);
        if (!entry.scene) {
            keep(entry, {light::refinedWith(edges, original, pose), edges});
            made = entry.scene;
        }
        return entry.scene;
    });
    if (!stored) {
        const std::lock_guard lock(entry.making);
        if (made && entry.scene == made) entry.scene.reset();
        return false;
    }
    entry.onDisk = entry.onDisk || made;
    baker_->keep(std::make_shared<const light::SurfaceLight>(*std::move(stored)));
    return true;
}

void SceneLights::begin(const std::shared_ptr<const Scene>& original, light::BakeInput input) {
    const std::shared_ptr<Refined>& entry = entryOf(*original);
    entry->onDisk = false;
    const auto bake = std::make_shared<light::BakeInput>(std::move(input));
    baker_->begin(bake->key, [bake, original, refined = entry, options = options_] {
        if (options.begin) bake->kept = options.begin(original->id);
        if (options.begin && !bake->kept) {
            throw std::runtime_error("renderers ended while they computed that of " + original->id);
        }
        {
            const std::lock_guard lock(refined->making);
            if (!refined->scene) {
                keep(*refined, light::refined(*original, *bake->pose,
                                              {.addedTriangles = options.addedTriangles}));
            }
            bake->scene = refined->scene;
            bake->edges = refined->edges;
        }
        return std::make_unique<light::Bake>(std::move(*bake),
                                             light::BakeQuality{.places = options.places});
    });
}

std::shared_ptr<const light::SurfaceLight> SceneLights::latest(std::uint64_t key) {
    auto light = baker_->latest(key);
    if (light && open_ && open_->key == key) open_.reset();
    return light;
}

std::shared_ptr<const light::SurfaceLight> SceneLights::open(const light::OpenLightInput& input) {
    if (!open_ || open_->key != input.key || open_->scene != input.scene) {
        open_ = std::make_shared<const light::SurfaceLight>(light::openLight(input));
    }
    return open_;
}

void SceneLights::releaseOpen(const std::function<bool(const Scene&)>& isShown) {
    if (open_ && (!isShown(*open_->scene) || baker_->latest(open_->key))) open_.reset();
}

LightState SceneLights::state(std::uint64_t key) const {
    const light::Baker::State now = baker_->state(key);
    const auto latest = baker_->latest(key);
    return {.wanted = true,
            .complete = now.complete,
            .revision = latest ? latest->revision : 0,
            .share = now.share,
            .failure = now.failure,
            .wait = [baker = baker_, key](const std::function<bool()>& abandoned) {
                baker->wait(key, abandoned);
            }};
}

std::function<LightProgress()> SceneLights::now(std::uint64_t key) const {
    return [baker = baker_, key] {
        const auto latest = baker->latest(key);
        return LightProgress{.revision = latest ? latest->revision : 0,
                             .share = latest ? latest->share : 0.0,
                             .failed = !baker->state(key).failure.empty()};
    };
}

void SceneLights::addShown(const Scene& original, const std::shared_ptr<const Scene>& refined) {
    auto& shown = entryOf(original)->shown;
    if (std::find(shown.begin(), shown.end(), refined) == shown.end()) shown.push_back(refined);
}

std::vector<const Scene*> SceneLights::replaced() const {
    std::vector<const Scene*> scenes;
    for (const auto& [original, refined] : refined_) {
        if (!refined->shown.empty()) scenes.push_back(original);
    }
    return scenes;
}

std::vector<std::shared_ptr<const Scene>> SceneLights::forget(const Scene& original) {
    if (open_ && open_->scene.get() == &original) open_.reset();
    const auto found = refined_.find(&original);
    if (found == refined_.end()) return {};
    std::vector<std::shared_ptr<const Scene>> shown = std::move(found->second->shown);
    for (const auto& scene : shown) baker_->forget(*scene);
    refined_.erase(found);
    return shown;
}

std::vector<std::shared_ptr<const Scene>> SceneLights::releaseStored(
    const std::function<bool(const Scene&)>& isShown) {
    std::vector<const Scene*> originals;
    for (const auto& [original, entry] : refined_) {
        const bool used = std::any_of(entry->shown.begin(), entry->shown.end(),
                                      [&](const auto& scene) { return isShown(*scene); });
        if (entry->onDisk && !entry->shown.empty() && !used) originals.push_back(original);
    }
    std::vector<std::shared_ptr<const Scene>> released;
    for (const Scene* original : originals) {
        for (auto& scene : forget(*original)) released.push_back(std::move(scene));
    }
    return released;
}

}  // namespace clerestory
