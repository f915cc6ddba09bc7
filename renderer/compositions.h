// The scenes that requests compose of loaded ones: several scenes in one, nodes changed, a ground.
// Each is made when it is first drawn and kept while it is among the last; loaded scenes never
// change.
//
//     const auto whole = compositions.joined({table, lamp}, request.parts);
//     const auto shown = compositions.composed(whole, compositionOf(request));
//
// Does not: check requests, know OpenGL; what an owner holds for a scene is uploaded and released
// by the two functions that it gives.
#pragma once

#include "scene/compose.h"
#include "scene/join.h"
#include "scene/scene.h"

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <span>
#include <vector>

namespace clerestory {

class Compositions {
public:
    using ScenePointer = std::shared_ptr<const Scene>;
    struct Owner {
        // Called with a new scene before it is kept; may throw, then it is not. The images of the
        // scene are those of `sources`, one after another.
        std::function<void(const std::shared_ptr<Scene>& made,
                           std::span<const Scene* const> sources)>
            upload;
        std::function<void(const ScenePointer& scene)> release;
    };
    explicit Compositions(Owner owner) : owner_(std::move(owner)) {}

    // The loaded scenes that a request names, in one; see clerestory::joined().
    ScenePointer joined(const std::vector<ScenePointer>& loaded,
                        const std::vector<PlacedScene>& parts);
    // A loaded or joined scene as the request changes it; the scene itself if it changes nothing.
    ScenePointer composed(const ScenePointer& base, const Composition& composition);

    // Releases everything that was made of a loaded scene.
    void forget(const ScenePointer& loaded);

    static constexpr std::size_t kMaxScenes = 4;
    static constexpr std::uint64_t kMaxBytes = kMaxJoinedBytes;

private:
    struct Kept {
        std::vector<ScenePointer> loaded;  // that it was made of
        ScenePointer scene;
    };
    // Moves it to the front. Null if it is not kept.
    ScenePointer find(const std::vector<ScenePointer>& loaded, std::uint64_t contentHash);
    ScenePointer keep(std::vector<ScenePointer> loaded, Scene made,
                      std::span<const Scene* const> sources);
    std::vector<ScenePointer> loadedOf(const ScenePointer& base) const;
    void discardOld();

    const Owner owner_;
    std::list<Kept> kept_;  // the one used last first
};

}  // namespace clerestory
