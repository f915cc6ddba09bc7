// Fields of a frame whose bytes are the same at any time: the light between surfaces, which is
// computed in the background, has tests of its own.
#pragma once

#include <string>

namespace clerestory::test {

inline const std::string kPlainEffects = R"("effects": {"shadows": false, "indirectLight": false})";
inline const std::string kPlainLink = "&shadows=0&indirectLight=0";

}  // namespace clerestory::test
