// The choice of a method for a reflector or a piece of glass, and reports of what was left out.
// Shared by the effects.
#pragma once

#include "plan/cost/cost.h"
#include "plan/effects/view_context.h"

#include <optional>

namespace clerestory {

// Below this roughness reflections are sharp: the blur is narrower than a pixel of a typical frame.
inline constexpr double kSharpRoughness = 0.02;

// A surface, or surfaces that share one picture, for which a method is chosen.
struct MethodRequest {
    Subject subject;
    Effect effect;
    double share = 0.0;            // fraction of the view's picture, 0..1
    double weight = 0.0;           // of the surface in the view, 0..1; see kMinWeight
    std::optional<Method> forced;  // named by the request
};
// Returns the chosen method. Records the decision if the view is the root.
Method chooseMethod(ViewContext& context, const ViewTask& task, const MethodRequest& requested,
                    std::span<const Candidate> candidates);

// The share of the picture, 0..1, that a surface counts as when its method is chosen. A wrong
// reflection of a bright sky in a dark room is noticeable on small surfaces too, and so is glass
// that shows it instead of what lies behind: below 5 % of the picture the result falls with the
// root of the share. `draft` uses the share itself.
double noticedShare(double share, Preset preset);

// Records why something is left out of the root view. Does nothing for child views.
void skip(ViewContext& context, const ViewTask& task, const Subject& subject, Effect effect,
          std::string reason);

// Returns true if an occluder hides the whole box (relative to the eye), and records it. Root view
// only; false for child views.
bool skipIfOccluded(ViewContext& context, const ViewTask& task, const Subject& subject,
                    Effect effect, const Bounds& box);

// The method for a value of PlanarMethod, CurvedMethod or GlassMethod; none for automatic.
// `specific` is the method that only this enumeration has: mirrored view, captured cube or
// backdrop.
template <class Requested>
std::optional<Method> requestedMethod(Requested requested, Method specific) {
    switch (requested) {
        case Requested::automatic:
            return std::nullopt;
        case Requested::environment:
            return Method::environment;
        case Requested::traced:
            return Method::traced;
        default:
            return specific;
    }
}

// Display name of the object of a surface: that of its node, of its mesh, or its number. nameOf()
// appends the number of the flat part.
std::string objectName(const Scene& scene, const Surface& surface);
std::string nameOf(const Scene& scene, const Surface& surface);

// One number in a text, such as formatted("%.1f ms predicted", 3.2); at most 159 characters.
std::string formatted(const char* pattern, double value);

// "12.3 % of the frame"
std::string percentOfFrame(double share);

// Number of levels of a picture that is read blurred, and of a prefiltered cube. Sizes in texels.
std::uint32_t pictureLevels(std::uint32_t width, std::uint32_t height);
std::uint32_t roughnessLevels(std::uint32_t faceSize);

// Reflectance at the viewing angle, 0..1 (Schlick 1994). reflectance: at normal incidence, 0..1;
// cosine: of the angle to the normal.
double reflectanceSeen(double reflectance, double cosine);

// Fraction of the directions from the centre of the box that geometry blocks, 0..1; see
// enclosure.h. The box is relative to the eye of the root view. 0 in child views, where it would
// have to be computed for each of them.
double enclosureAt(ViewContext& context, const ViewTask& task, const Bounds& box);

}  // namespace clerestory
