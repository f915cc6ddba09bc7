#include "plan/effects/method_choice.h"

#include "plan/visibility/enclosure.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace clerestory {

std::string formatted(const char* pattern, double value) {
    char text[160];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

namespace {

// The candidate on which the views of a lens agreed, if they chose different ones.
std::optional<std::size_t> agreedCandidate(const ViewContext& context, const ViewTask& task,
                                           const Subject& subject,
                                           std::span<const Candidate> candidates) {
    if (task.generation > 0 || context.agreed.empty()) return std::nullopt;
    const auto agreed = context.agreed.find(nameOf(subject));
    if (agreed == context.agreed.end()) return std::nullopt;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (candidates[i].method == agreed->second) return i;
    }
    return std::nullopt;
}

}  // namespace

Method chooseMethod(ViewContext& context, const ViewTask& task, const MethodRequest& requested,
                    std::span<const Candidate> candidates) {
    const double weight = task.weight * requested.weight;
    const double tolerance = acceptedError(context.stage.settings.accuracy.preset, weight);
    std::size_t chosen = cheapest(candidates, tolerance);
    const double share = requested.share * task.part;
    std::string reason = percentOfFrame(share);
    const auto forced = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
        return requested.forced && c.method == *requested.forced;
    });
    if (forced != candidates.end()) {
        chosen = static_cast<std::size_t>(forced - candidates.begin());
        reason += ", named by the request";
    } else if (const auto agreed = agreedCandidate(context, task, requested.subject, candidates)) {
        chosen = *agreed;
        reason += ", as in another view of the lens";
    } else {
        reason += formatted(", %.1f ms predicted", candidates[chosen].milliseconds) +
                  formatted(", error %.2f", candidates[chosen].error) +
                  formatted(" where %.2f is enough", std::min(tolerance, 99.0));
    }
    if (task.generation == 0) {
        context.builder.addDecision({nameOf(requested.subject),
                                     requested.subject,
                                     requested.effect,
                                     task.generation,
                                     share,
                                     candidates[chosen].method,
                                     {candidates.begin(), candidates.end()},
                                     std::move(reason)});
    }
    return candidates[chosen].method;
}

double noticedShare(double share, Preset preset) {
    constexpr double kSmall = 0.05;
    return preset == Preset::draft ? share : std::max(share, std::sqrt(share * kSmall));
}

void skip(ViewContext& context, const ViewTask& task, const Subject& subject, Effect effect,
          std::string reason) {
    if (task.generation == 0) {
        if (!task.subject.name.empty()) reason = task.subject.name + ": " + reason;
        context.builder.skip(subject, effect, std::move(reason));
    }
}

bool skipIfOccluded(ViewContext& context, const ViewTask& task, const Subject& subject,
                    Effect effect, const Bounds& box) {
    if (task.generation > 0) return false;
    const Occluder* occluder = findOccluder(context.occluders, task.view, box);
    if (occluder != nullptr) {
        const Surface& surface = context.stage.surfaces[occluder->surface];
        skip(context, task, subject, effect,
             "hidden behind " + nameOf(context.stage.scene, surface));
    }
    return occluder != nullptr;
}

std::string objectName(const Scene& scene, const Surface& surface) {
    const Instance& instance = scene.instances[surface.instance];
    std::string name = scene.nodes[instance.node].name;
    if (name.empty()) name = scene.meshes[instance.mesh].name;
    if (name.empty()) name = "object " + std::to_string(surface.instance + 1);
    return name;
}

std::string nameOf(const Scene& scene, const Surface& surface) {
    const Instance& instance = scene.instances[surface.instance];
    std::string name = objectName(scene, surface);
    if (surface.flatPart != kNone) {
        const std::uint32_t part = surface.flatPart - scene.meshes[instance.mesh].firstFlatPart;
        if (part > 0) name += " part " + std::to_string(part + 1);
    }
    return name;
}

std::string percentOfFrame(double share) {
    return formatted("%.1f %% of the frame", 100.0 * share);
}

// The last level is 2 or 3 pixels wide: at roughness 0.5 a lobe covers half of a picture, and with
// fewer levels its blur would depend on the size of the picture.
std::uint32_t pictureLevels(std::uint32_t width, std::uint32_t height) {
    const auto full = static_cast<std::uint32_t>(std::bit_width(std::min(width, height)));
    return full > 1 ? full - 1 : 1;
}

// Down to faces of 4 texels: smaller ones add nothing to the spherical harmonics.
std::uint32_t roughnessLevels(std::uint32_t faceSize) {
    const auto full = static_cast<std::uint32_t>(std::bit_width(faceSize));
    return full > 3 ? full - 2 : 1;
}

double reflectanceSeen(double reflectance, double cosine) {
    const double edge = 1.0 - std::clamp(cosine, 0.0, 1.0);
    return reflectance + (1.0 - reflectance) * edge * edge * edge * edge * edge;
}

double enclosureAt(ViewContext& context, const ViewTask& task, const Bounds& box) {
    if (task.generation > 0) return 0.0;
    if (!context.opaqueBoxes) context.opaqueBoxes.emplace(opaqueBoxes(context.stage, task.view));
    return enclosure(*context.opaqueBoxes, glm::dvec3(box.center()));
}

}  // namespace clerestory
