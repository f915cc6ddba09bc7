#include "scene/builtin/builtin_scenes.h"

#include "scene/builtin/small_scenes.h"

namespace clerestory {
namespace {

struct Entry {
    BuiltinScene scene;
    Scene (*make)();
};

const std::vector<Entry>& entries() {
    static const std::vector<Entry> list = {
        {{"chapel", "Chapel"}, chapel},
        {{"six-walls", "Six walls"}, sixWalls},
        {{"orbiting-cubes", "Orbiting cubes"}, orbitingCubes},
        {{"teapots", "Teapots"}, teapots},
        {{"meadow", "Meadow"}, meadow},
    };
    return list;
}

}  // namespace

std::vector<BuiltinScene> builtinScenes() {
    std::vector<BuiltinScene> list;
    for (const Entry& entry : entries()) list.push_back(entry.scene);
    return list;
}

std::optional<Scene> makeBuiltinScene(const std::string& id) {
    for (const Entry& entry : entries()) {
        if (entry.scene.id != id) continue;
        Scene scene = entry.make();
        scene.id = id;
        scene.title = entry.scene.title;
        updateContentHash(scene);
        return scene;
    }
    return std::nullopt;
}

}  // namespace clerestory
