// Textures that say where the pixels of a frame read the tiles of its lens. They are kept for the
// next frames of the same lens and size.
#pragma once

#include "gl/texture.h"
#include "plan/graph/picture_passes.h"

#include <list>
#include <optional>

namespace clerestory {

class LensLookups {
public:
    struct Part {
        TargetRect rect;                     // of the frame
        std::optional<gl::Texture> lookups;  // TileLookups::texels; none for an empty rectangle
    };
    // One for each tile of the pass, until the next call.
    const std::list<Part>& of(const AssembleLens& work);

private:
    struct Entry {
        AssembleLens key;  // without sources
        std::list<Part> parts;
        std::uint64_t bytes = 0;
    };
    std::list<Entry> entries_;  // last used first
};

}  // namespace clerestory
