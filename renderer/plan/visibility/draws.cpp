#include "plan/visibility/draws.h"

#include "plan/cost/cost.h"
#include "plan/graph/features.h"
#include "plan/visibility/culling.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/material_features.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace clerestory {
namespace {

// True if nine harmonics of the environment represent what the specular lobe gathers, within a
// quarter of the tolerance.
bool hasWideLobe(const Material& m, const Stage& stage) {
    if (m.unlit || m.metallic > 0.0f || m.metallicRoughnessTexture.present()) return false;
    const float root = (m.ior - 1.0f) / (m.ior + 1.0f);
    const float reflected = root * root + 0.02f;  // and what it reflects towards the edge
    // Textures are usually darker than their factor.
    const float kTextured = 0.3f;
    const float albedo = (m.baseColor.r + m.baseColor.g + m.baseColor.b) / 3.0f *
                         (m.baseColorTexture.present() ? kTextured : 1.0f);
    const float error =
        reflected / (reflected + albedo) * harmonicError(stage.environment, m.roughness);
    return 4.0 * error <= toleranceOf(stage.settings.accuracy.preset);
}

// Features of surfaces that reflect another picture than the harmonics of the environment.
constexpr Features kOtherPicture = FEATURE_MIRROR | FEATURE_PROBE | FEATURE_MAP |
                                   FEATURE_TRACED_REFLECTION | FEATURE_GLASS | FEATURE_TRACED_GLASS;

// If one surface of the scene has these features, all surfaces get them: that costs less than a
// program for each combination. Materials without the texture sample white; without emission they
// add 0.
constexpr Features kShared = FEATURE_OCCLUSION_MAP | FEATURE_EMISSION;

// The same where few programs matter more than fast ones. The bytes of frames are those of separate
// programs: white textures are exactly 1, identity transforms return their argument.
constexpr Features kSharedByFew =
    kShared | FEATURE_BASE_COLOR_MAP | FEATURE_METALLIC_ROUGHNESS_MAP | FEATURE_EMISSIVE_MAP |
    FEATURE_VERTEX_COLOR | FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_TEXCOORD;

// The features of a draw's program. `ofAll`, `ofGlass`: those that all surfaces and all glass
// share. TransmissionTest draws 8 programs instead of 22, the chapel 12 instead of 15.
Features programFeatures(Features f, Features ofAll, Features ofGlass) {
    if (f & FEATURE_UNLIT) return f;
    Features shared = ofAll;
    if (f & (FEATURE_GLASS | FEATURE_TRACED_GLASS)) {
        shared |= ofGlass;
        // Occludes diffuse light only, which glass does not have.
        shared &= ~FEATURE_OCCLUSION_MAP;
        f &= ~FEATURE_OCCLUSION_MAP;
    }
    // Such a normal map holds another material's metallic and roughness.
    const bool foreign = (f & FEATURE_PACKED_NORMAL) && !(f & FEATURE_METALLIC_ROUGHNESS_MAP);
    if (foreign) shared &= ~FEATURE_METALLIC_ROUGHNESS_MAP;
    f |= shared;
    // Normal maps without other numbers are shaded differently; see surface.frag.
    const bool sharesNumbers =
        f & (FEATURE_GLASS | FEATURE_TRACED_GLASS) || (shared & FEATURE_METALLIC_ROUGHNESS_MAP);
    if (sharesNumbers && !(f & FEATURE_NORMAL_MAP)) f &= ~FEATURE_DEFAULT_NUMBERS;
    return f;
}

struct OrderedDraw {
    Draw draw;
    double distance;  // from the eye to the nearest point of its box, metres
    double share;     // fraction of the picture that its box covers
};

bool continues(const Draw& before, const Draw& next) {
    return before.instance == next.instance && before.features == next.features &&
           before.reflection == next.reflection && before.label == next.label &&
           before.lights == next.lights && before.firstIndex + before.indexCount == next.firstIndex;
}

std::vector<Draw> merged(const std::vector<OrderedDraw>& draws) {
    std::vector<Draw> result;
    for (const OrderedDraw& next : draws) {
        if (!result.empty() && continues(result.back(), next.draw))
            result.back().indexCount += next.draw.indexCount;
        else
            result.push_back(next.draw);
    }
    return result;
}

// Index and instance break ties, so that the order does not depend on the sort algorithm.
bool nearer(const OrderedDraw& a, const OrderedDraw& b) {
    return std::tie(a.distance, a.draw.firstIndex, a.draw.instance) <
           std::tie(b.distance, b.draw.firstIndex, b.draw.instance);
}
bool sameStateFirst(const OrderedDraw& a, const OrderedDraw& b) {
    const auto key = [](const OrderedDraw& c) {
        return std::tie(c.draw.features, c.draw.material, c.draw.reflection, c.draw.instance,
                        c.draw.firstIndex);
    };
    return key(a) < key(b);
}

std::vector<Draw> depthDraws(std::vector<OrderedDraw> draws) {
    std::erase_if(draws, [](const OrderedDraw& each) {
        return each.draw.primitive != Primitive::triangles ||
               each.share < kOccluderShare * (each.draw.indexCount / 3);
    });
    for (OrderedDraw& each : draws) {
        each.draw.features &= FEATURE_DOUBLE_SIDED;
        each.draw.reflection = kNoReflection;
        each.draw.lights = {};
    }
    std::sort(draws.begin(), draws.end(), nearer);
    return merged(draws);
}

double indexCount(const Stage& stage, const Surface& surface) {
    double indices = 0.0;
    for (std::uint32_t c = 0; c < surface.clusterCount; ++c) {
        indices += stage.scene.clusters[surface.firstCluster + c].indexCount;
    }
    return std::max(indices, 1.0);
}

// The fraction of the triangles of the surface that are in view, 0..1.
double seenTriangles(const Stage& stage, const SeenSurface& seen) {
    double indices = 0.0;
    for (const SeenCluster& cluster : seen.clusters) indices += cluster.indexCount;
    return indices / indexCount(stage, *seen.surface);
}

// area: of the clusters in view, square metres. They fill the boxes of the clusters in part.
double shareOfFlat(const View& view, const Plane& plane, const SeenSurface& seen, double area) {
    FlatExtent sum;
    for (const SeenCluster& cluster : seen.clusters) {
        const FlatExtent extent = flatExtent(view, cluster.box, plane);
        sum.area += extent.area;
        sum.share += extent.share;
    }
    return kFlatUnhidden * sum.share * std::min(1.0, area / std::max(sum.area, 1e-300));
}

// For meshes of many small objects: each cluster has a part of the area in proportion to its
// triangles, and its own distance.
double shareOfClusters(const Stage& stage, const View& view, const SeenSurface& seen, double area) {
    const double indices = indexCount(stage, *seen.surface);
    double sum = 0.0;
    for (const SeenCluster& cluster : seen.clusters) {
        const double part = area * cluster.indexCount / indices;
        sum += std::min(kBoxFill * cluster.share, areaShare(view, cluster.box, part));
    }
    return sum;
}

double shareIn(const Stage& stage, const View& view, const glm::dmat4& toEye,
               const SeenSurface& seen, std::span<const ScreenBox> rects) {
    const Surface& surface = *seen.surface;
    if (surface.flatPart == kNone) {
        const double area = transformedArea(toEye, surface.area, std::nullopt);
        const double whole = shareOf(view, rects, seen.box, area);
        // The constants for rays and backdrops were measured with whole pieces of glass.
        if (surface.glass != Glass::none) return whole;
        return std::min(whole, shareOfClusters(stage, view, seen, area));
    }
    const FlatPart& part = stage.scene.flatParts[surface.flatPart];
    const double area = transformedArea(toEye, surface.area, part.normal);
    const std::optional<Plane> plane = transformed(part.plane(), toEye);
    if (!plane) return 0.0;  // scaled to nothing
    return std::min(unionShare(rects),
                    shareOfFlat(view, *plane, seen, area * seenTriangles(stage, seen)));
}

}  // namespace

SeenView seenFrom(const Stage& stage, const View& view, std::span<const std::size_t> hidden) {
    SeenView result;
    const Scene& scene = stage.scene;
    Culling culling(stage, view);
    std::vector<ScreenBox> rects;  // of the surface's clusters
    result.glassFeatures = texturesOfGlass(stage);
    for (std::size_t i = 0; i < stage.surfaces.size(); ++i) {
        const Surface& surface = stage.surfaces[i];
        const Material& material = stage.material(surface);
        const Mesh& mesh = scene.meshes[scene.instances[surface.instance].mesh];
        const Features features = materialFeatures(scene, material, mesh, stage.settings.effects);
        result.sharedFeatures |= features & (stage.fewPrograms ? kSharedByFew : kShared);
        if (std::binary_search(hidden.begin(), hidden.end(), i)) continue;
        SeenSurface seen{.surface = &surface,
                         .features = features,
                         .primitive = mesh.primitive,
                         .pointSize = stage.settings.pointSize};
        const bool unlit = (features & FEATURE_UNLIT) != 0;
        if (!unlit && hasWideLobe(material, stage)) seen.features |= FEATURE_WIDE_LOBE;
        if (isShadowCatcher(scene, surface.instance)) {
            seen.features |= ofLayers(LAYER_SHADOW_CATCHER);
        }
        rects.clear();
        const bool opaque = mesh.primitive == Primitive::triangles &&
                            !(seen.features & (FEATURE_BLEND | FEATURE_MASK));
        result.clusters += surface.clusterCount;
        result.culled +=
            culling.eachInView(surface, [&](const Cluster& cluster, const Bounds& box) {
                const ScreenBox rect = screenBox(view, box);
                const double share = rect.share();
                SeenCluster part{
                    cluster.firstIndex, cluster.indexCount, distanceTo(box), share, {}, box};
                if (!unlit) {
                    std::uint32_t reaching = 0;
                    part.lights = lightsReaching(stage.lights, view.eye, box, reaching);
                    result.maxLights = std::max(result.maxLights, reaching);
                }
                if (opaque) result.overdraw += kBoxFill * share;
                rects.push_back(rect);
                seen.box.add(box);
                seen.clusters.push_back(part);
                result.triangles += cluster.indexCount / indicesPer(mesh.primitive);
                result.anyLit |= !unlit;
                result.anyEmissive |= (seen.features & FEATURE_EMISSION) != 0;
            });
        if (seen.clusters.empty()) continue;
        const bool needsEffect =
            surface.glass != Glass::none || surface.reflector != Reflector::none;
        if (needsEffect) seen.share = shareIn(stage, view, culling.toEye(), seen, rects);
        result.surfaces.push_back(std::move(seen));
    }
    return result;
}

DrawLists drawLists(const SeenView& view) {
    DrawLists lists;
    std::vector<OrderedDraw> opaque, masked;
    for (std::size_t i = 0; i < view.surfaces.size(); ++i) {
        const SeenSurface& seen = view.surfaces[i];
        // A ground that catches shadows is below everything that is seen before it.
        const bool below = (seen.features & ofLayers(LAYER_SHADOW_CATCHER)) != 0;
        for (const SeenCluster& cluster : seen.clusters) {
            Draw draw{.instance = seen.surface->instance,
                      .material = seen.surface->material,
                      .firstIndex = cluster.firstIndex,
                      .indexCount = cluster.indexCount,
                      .features = seen.features,
                      .reflection = seen.reflection,
                      .label = seen.label,
                      .lights = cluster.lights,
                      .primitive = seen.primitive};
            if (draw.primitive != Primitive::triangles) draw.pointSize = seen.pointSize;
            if (cluster.lights.count > 0) draw.features |= FEATURE_LIGHTS;
            if (draw.features & kOtherPicture) draw.features &= ~FEATURE_WIDE_LOBE;
            draw.features = programFeatures(draw.features, view.sharedFeatures, view.glassFeatures);
            if (seen.overBackdrop || (seen.features & FEATURE_BLEND))
                lists.through.push_back(
                    {below ? std::numeric_limits<double>::infinity() : cluster.distance,
                     seen.overBackdrop, i, draw, cluster.box});
            else
                (seen.features & FEATURE_MASK ? masked : opaque)
                    .push_back({draw, cluster.distance, cluster.share});
        }
    }
    if (view.overdraw > kPrepassOverdraw) lists.depth = depthDraws(opaque);
    std::sort(opaque.begin(), opaque.end(), lists.depth.empty() ? nearer : sameStateFirst);
    std::sort(masked.begin(), masked.end(), nearer);
    opaque.insert(opaque.end(), masked.begin(), masked.end());
    lists.opaque = merged(opaque);
    // If the eye is inside several boxes (panes at an angle), their centres determine the order.
    const auto key = [&](const DrawLists::Behind& b) {
        const double middle = glm::length(glm::dvec3(view.surfaces[b.seen].box.center()));
        return std::tuple(-b.distance, -middle, b.draw.firstIndex, b.draw.instance);
    };
    std::sort(lists.through.begin(), lists.through.end(),
              [&](const auto& a, const auto& b) { return key(a) < key(b); });
    return lists;
}

ScreenBox coveredBy(std::span<const Draw> draws, const View& view, const Stage& stage) {
    ScreenBox covered;
    for (const Draw& draw : draws) {
        const Instance& instance = stage.scene.instances[draw.instance];
        const ScreenBox box = screenBox(
            view, transformed(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]),
                              eyeFromLocal(view, stage.pose.worldFromNode[instance.node])));
        if (box.empty()) continue;
        covered.low = glm::min(covered.low, box.low);
        covered.high = glm::max(covered.high, box.high);
    }
    return covered;
}

}  // namespace clerestory
