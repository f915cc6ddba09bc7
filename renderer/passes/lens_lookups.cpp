#include "passes/lens_lookups.h"

#include <algorithm>
#include <span>

namespace clerestory {
namespace {

// Of all entries except the last used one.
constexpr std::uint64_t kMaxBytes = 128ull << 20;

AssembleLens keyOf(AssembleLens work) {
    work.sources.clear();
    return work;
}

}  // namespace

const std::list<LensLookups::Part>& LensLookups::of(const AssembleLens& work) {
    AssembleLens key = keyOf(work);
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.key == key; });
    if (found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
        return entries_.front().parts;
    }
    std::uint64_t bytes = 0;
    for (auto entry = entries_.begin(); entry != entries_.end();) {
        bytes += entry->bytes;
        entry = bytes > kMaxBytes ? entries_.erase(entry) : std::next(entry);
    }
    Entry entry{.key = std::move(key)};
    for (const TileLookups& tile : lookupsOf(work.lens, work.tiles, !work.numbers)) {
        Part& part =
            entry.parts.emplace_back(Part{.rect = {tile.x, tile.y, tile.width, tile.height}});
        if (tile.texels.empty()) continue;
        part.lookups.emplace(gl::TextureDescription{
            .format = gl::TextureFormat::rgba32f, .width = tile.width, .height = tile.height});
        part.lookups->upload(0, 0, std::as_bytes(std::span(tile.texels)));
        entry.bytes += tile.texels.size() * sizeof(glm::vec4);
    }
    entries_.push_front(std::move(entry));
    return entries_.front().parts;
}

}  // namespace clerestory
