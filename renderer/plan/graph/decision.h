// The techniques among which the planner chooses, and a record of each choice.
#pragma once

#include "plan/graph/effect.h"

#include <string>
#include <vector>

namespace clerestory {

// How a reflector or a piece of glass is served.
enum class Method {
    environment,  // by the environment map
    probe,        // by a captured cube
    mirror,       // by a picture from the mirrored eye
    backdrop,     // glass: by a copy of what was drawn behind it
    traced,       // by rays through the mesh
};
struct Candidate {
    Method method = Method::environment;
    double milliseconds = 0.0;  // predicted; see plan/cost/cost.h
    double error = 0.0;         // predicted relative RMSE on the surface's pixels
    bool operator==(const Candidate&) const = default;
};
// A decision of the planner: what there was to choose from, and what was taken.
struct Decision {
    std::string name;
    Effect effect = Effect::base;
    std::uint32_t generation = 0;
    double share = 0.0;  // of the frame that it covers, about
    Method taken = Method::environment;
    std::vector<Candidate> candidates;
    std::string reason;
    bool operator==(const Decision&) const = default;
};

std::string_view nameOf(Method method);

}  // namespace clerestory
