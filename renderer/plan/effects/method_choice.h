// Choosing how a reflector or a piece of glass is rendered, and reporting what was left out. Used
// by every effect.
#pragma once

#include "plan/cost/cost.h"
#include "plan/effects/view_context.h"

#include <optional>

namespace clerestory {

// Surfaces smoother than this show sharp pictures: their blur is narrower than a pixel of a common
// frame.
inline constexpr double kSharpRoughness = 0.02;

// A surface, or surfaces that share one picture, for which a method is chosen.
struct Subject {
    std::string name;
    Effect effect;
    double share = 0.0;            // of the view's picture, 0..1
    double weight = 0.0;           // of the view's light; see kMinWeight
    std::optional<Method> forced;  // the request names it
};
// Returns the candidate's method, and records the decision when the view is the root.
Method chooseMethod(ViewContext& context, const ViewTask& task, Subject subject,
                    std::span<const Candidate> candidates);

// Records why something is left out of the root view. Child views are not reported: their passes
// show what they draw.
void skip(ViewContext& context, const ViewTask& task, std::string name, Effect effect,
          std::string reason);

// True when a wall of the root view hides all of the box (relative to the eye); records it.
bool skipIfOccluded(ViewContext& context, const ViewTask& task, const std::string& name,
                    Effect effect, const Bounds& box);

// The method that a field of Accuracy names; `own` is that of the enumeration's own kind: a
// mirrored view, a captured cube, a backdrop. None where the planner chooses.
template <class Word>
std::optional<Method> requestedMethod(Word word, Method own) {
    switch (word) {
        case Word::automatic:
            return std::nullopt;
        case Word::environment:
            return Method::environment;
        case Word::traced:
            return Method::traced;
        default:
            return own;
    }
}

// The name of a surface's object for people: its node's, its mesh's, or its number; of a flat part
// with the part's number.
std::string objectName(const Scene& scene, const Surface& surface);
std::string nameOf(const Scene& scene, const Surface& surface);

// "12.3 % of the frame"
std::string percentOfFrame(double share);

// Levels of a picture that is read blurred, and of a prefiltered cube.
std::uint32_t pictureLevels(std::uint32_t width, std::uint32_t height);
std::uint32_t roughnessLevels(std::uint32_t faceSize);

// Reflectance at the angle of view, 0..1 (Schlick). cosine: of the angle to the normal.
double reflectanceSeen(double reflectance, double cosine);

}  // namespace clerestory
