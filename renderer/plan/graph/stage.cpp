#include "plan/graph/stage.h"

#include <algorithm>

namespace clerestory {

void Stage::addMaterial(PlanHash& hash, Index index) const {
    const std::size_t ofScene = scene.materials.size();
    hash.add(std::min<std::size_t>(index, ofScene));
    if (index >= ofScene) hash.add(ownHashes[index - ofScene]);
}

}  // namespace clerestory
