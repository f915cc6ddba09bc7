#include "compositions.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace clerestory {

Compositions::ScenePointer Compositions::find(const std::vector<ScenePointer>& loaded,
                                              std::uint64_t contentHash) {
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) {
        return k.scene->contentHash == contentHash && k.loaded == loaded;
    });
    if (found == kept_.end()) return nullptr;
    kept_.splice(kept_.begin(), kept_, found);
    return kept_.front().scene;
}

Compositions::ScenePointer Compositions::keep(std::vector<ScenePointer> loaded, Scene made,
                                              std::span<const Scene* const> sources) {
    const auto scene = std::make_shared<Scene>(std::move(made));
    owner_.upload(scene, sources);
    kept_.push_front({std::move(loaded), scene});
    discardOld();
    return scene;
}

std::vector<Compositions::ScenePointer> Compositions::loadedOf(const ScenePointer& base) const {
    const auto found =
        std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.scene == base; });
    return found == kept_.end() ? std::vector{base} : found->loaded;
}

void Compositions::discardOld() {
    const auto bytes = [&] {
        std::uint64_t sum = 0;
        for (const Kept& k : kept_) sum += geometryBytes(*k.scene);
        return sum;
    };
    while (kept_.size() > 1 && (kept_.size() > kMaxScenes || bytes() > kMaxBytes)) {
        owner_.release(kept_.back().scene);
        kept_.pop_back();
    }
}

Compositions::ScenePointer Compositions::joined(const std::vector<ScenePointer>& loaded,
                                                const std::vector<PlacedScene>& parts) {
    std::vector<const Scene*> scenes;
    for (const ScenePointer& scene : loaded) scenes.push_back(scene.get());
    const std::vector<ScenePart> placed = scenePartsOf(parts, scenes);
    if (auto known = find(loaded, contentHash(placed))) return known;
    return keep(loaded, clerestory::joined(placed), scenes);
}

Compositions::ScenePointer Compositions::composed(const ScenePointer& base,
                                                  const Composition& composition) {
    if (composition.empty()) return base;
    std::vector<ScenePointer> loaded = loadedOf(base);
    if (auto known = find(loaded, contentHash(*base, composition))) return known;
    const Scene* const source[] = {base.get()};
    return keep(std::move(loaded), clerestory::composed(*base, composition), source);
}

void Compositions::forget(const ScenePointer& loaded) {
    std::erase_if(kept_, [&](const Kept& k) {
        const bool madeOfIt = std::find(k.loaded.begin(), k.loaded.end(), loaded) != k.loaded.end();
        if (madeOfIt) owner_.release(k.scene);
        return madeOfIt;
    });
}

}  // namespace clerestory
