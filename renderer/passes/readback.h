// What a frame brings back beside its picture.
#pragma once

namespace clerestory {

enum class Readback {
    picture,  // nothing
    health,   // counts of texels that are not sound, of every float target of the plan
    maps,     // the mirrored views and cubes that the frame reads
};

}  // namespace clerestory
