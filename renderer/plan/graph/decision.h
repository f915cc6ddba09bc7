// The methods among which the planner chooses, and the record of a choice.
#pragma once

#include "plan/graph/effect.h"
#include "plan/graph/subject.h"

#include <string>
#include <vector>

namespace clerestory {

// Source of the light that a reflector or a piece of glass shows, and what hides a light.
enum class Method {
    environment,  // environment map
    probe,        // captured cube
    mirror,       // mirrored view
    backdrop,     // glass: a copy of the picture behind it
    traced,       // ray tracing through the mesh
    shadowMap,    // what hides a light: pictures from the light
    unshadowed,   // nothing hides the light
};
struct Candidate {
    Method method = Method::environment;
    double milliseconds = 0.0;  // predicted; see plan/cost/cost.h
    double error = 0.0;         // predicted relative RMSE on the surface's pixels
    bool operator==(const Candidate&) const = default;
};
// A choice between methods: the candidates, and the one that was taken.
struct Decision {
    std::string name;
    Subject subject;
    Effect effect = Effect::base;
    std::uint32_t generation = 0;
    double share = 0.0;  // estimated fraction of the frame that it covers, 0..1
    Method taken = Method::environment;
    std::vector<Candidate> candidates;
    std::string reason;
    bool operator==(const Decision&) const = default;
};

std::string_view nameOf(Method method);

}  // namespace clerestory
