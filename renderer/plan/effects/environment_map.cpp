#include "plan/effects/environment_map.h"

#include "plan/effects/method_choice.h"
#include "scene/hash.h"

#include <bit>

namespace clerestory {

TargetId environmentTarget(ViewContext& context) {
    if (!(context.stage.settings.environmentIntensity > 0.0f)) return kNoTarget;
    return mapTarget(context, context.frame.environment);
}

TargetId mapTarget(ViewContext& context, const EnvironmentMap& map, const MapBlur& blur) {
    PlanHash identity;
    identity.add(std::string_view("stored map"));
    identity.add(std::string_view(map.name));
    addBlur(identity, blur);
    PlanBuilder& builder = context.builder;
    if (const auto target = builder.shared(identity.value())) return *target;
    const Accuracy& a = context.stage.settings.accuracy;
    PlanHash hash;
    hash.add(map.contentHash);
    hash.add(a.environmentSize);
    hash.add(blur.changes() ? a.probeSamples : a.environmentSamples);
    if (blur.changes()) addBlur(hash, blur);
    const Subject subject{Subject::Kind::environment, map.name};
    const std::string name = nameOf(subject);
    const TargetId target = builder.addTarget({.name = name,
                                               .kind = TargetKind::cube,
                                               .format = Format::rgba16f,
                                               .width = a.environmentSize,
                                               .height = a.environmentSize,
                                               .levels = roughnessLevels(a.environmentSize),
                                               .residentKey = hash.value()});
    builder.share(identity.value(), target);
    if (context.frame.resident.keys.contains(hash.value())) {
        builder.skip(subject, Effect::base, "resident and unchanged");
        return target;
    }
    PlanBuilder::Transaction passes(builder);
    const char* reason = "lights the scene and is not resident at this accuracy";
    if (blur.changes()) {
        const TargetId blurred =
            addBlur(context, subject, blur, map.faceSize, 0, kNoTarget, map.name);
        context.builder.addPass({.name = name,
                                 .subject = subject,
                                 .effect = Effect::environmentReflection,
                                 .target = target,
                                 .reason = reason,
                                 .work = PrefilterCube{blurred, a.probeSamples}});
    } else {
        context.builder.addPass({.name = name,
                                 .subject = subject,
                                 .target = target,
                                 .reason = reason,
                                 .work = PrefilterMap{map.name, a.environmentSamples}});
    }
    passes.commit(target, hash.value());
    return target;
}

TargetId addBlur(ViewContext& context, const Subject& subject, const MapBlur& blur,
                 std::uint32_t faceSize, std::uint32_t generation, TargetId source,
                 const std::string& map) {
    const std::string name = nameOf(subject);
    TargetSpec spec{.name = name + ":blur",
                    .kind = TargetKind::cube,
                    .format = Format::rgba16f,
                    .width = faceSize,
                    .height = faceSize,
                    .levels = static_cast<std::uint32_t>(std::bit_width(faceSize))};
    const TargetId result = context.builder.addTarget(spec);
    spec.levels = 1;
    const TargetId between = context.builder.addTarget(spec);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const TargetId from = axis == 0 ? source : axis == 1 ? result : between;
        context.builder.addPass({.name = name + ":blur",
                                 .subject = subject,
                                 .effect = Effect::environmentReflection,
                                 .generation = generation,
                                 .target = axis == 1 ? between : result,
                                 .reason = "the map is requested with a Gaussian blur",
                                 .work = BlurCube{from, from == kNoTarget ? map : "", blur, axis}});
    }
    context.builder.addPass({.name = name + ":levels",
                             .subject = subject,
                             .effect = Effect::environmentReflection,
                             .generation = generation,
                             .target = result,
                             .reason = "prefiltering reads blurred levels",
                             .work = BuildLevels{}});
    return result;
}

}  // namespace clerestory
