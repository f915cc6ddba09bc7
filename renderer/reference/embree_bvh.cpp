#include "reference/embree_bvh.h"

#include "scene/fields.h"
#include "scene/geometry.h"

#include <stdexcept>
#include <utility>

namespace clerestory::reference {
namespace {

// Data for the filter callback.
struct FilteredQuery {
    embree::QueryContext context;  // first member: Embree passes its address to the filter
    const EmbreeBvh::HitFilter* accepts;
    std::uint32_t originTriangle;
};

// Embree calls this for every triangle along a ray.
void filter(const RTCFilterFunctionNArguments* args) {
    const auto& filtered = *reinterpret_cast<const FilteredQuery*>(args->context);
    for (unsigned lane = 0; lane < args->N; ++lane) {
        if (args->valid[lane] == 0) continue;
        const std::uint32_t triangle = RTCHitN_primID(args->hit, args->N, lane);
        const glm::dvec3 normal(RTCHitN_Ng_x(args->hit, args->N, lane),
                                RTCHitN_Ng_y(args->hit, args->N, lane),
                                RTCHitN_Ng_z(args->hit, args->N, lane));
        const glm::dvec3 direction(RTCRayN_dir_x(args->ray, args->N, lane),
                                   RTCRayN_dir_y(args->ray, args->N, lane),
                                   RTCRayN_dir_z(args->ray, args->N, lane));
        if (triangle == filtered.originTriangle ||
            !(*filtered.accepts)(triangle, RTCHitN_u(args->hit, args->N, lane),
                                 RTCHitN_v(args->hit, args->N, lane),
                                 glm::dot(normal, direction) < 0.0)) {
            args->valid[lane] = 0;
        }
    }
}

RTCRay embreeRay(const Ray& ray) {
    RTCRay r{};
    r.org_x = static_cast<float>(ray.origin.x);
    r.org_y = static_cast<float>(ray.origin.y);
    r.org_z = static_cast<float>(ray.origin.z);
    r.dir_x = static_cast<float>(ray.direction.x);
    r.dir_y = static_cast<float>(ray.direction.y);
    r.dir_z = static_cast<float>(ray.direction.z);
    r.tnear = static_cast<float>(ray.tMin);
    r.tfar =
        ray.tMax < 1e30 ? static_cast<float>(ray.tMax) : std::numeric_limits<float>::infinity();
    r.mask = 0xffffffffu;
    return r;
}

}  // namespace

// Built by one thread, so that of two coincident triangles the same one is always hit. Vertices are
// not shared, but vertices at one position have equal bits, so the robust mode leaves no gaps.
EmbreeBvh::EmbreeBvh(std::size_t triangles, const std::function<Corners(std::uint32_t)>& cornersOf,
                     HitFilter accepts)
    : accepts_(std::move(accepts)), device_(rtcNewDevice("threads=1,set_affinity=0")) {
    if (!device_) throw std::runtime_error("Embree could not create a device");
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
    if (triangles > 0) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* corners = static_cast<glm::vec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(glm::vec3), 3 * triangles));
        auto* indices = static_cast<std::array<std::uint32_t, 3>*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    sizeof(std::array<std::uint32_t, 3>), triangles));
        for (std::uint32_t i = 0; corners && indices && i < triangles; ++i) {
            const Corners triangle = cornersOf(i);
            for (std::uint32_t c = 0; c < 3; ++c) corners[3 * i + c] = triangle[c];
            indices[i] = {3 * i, 3 * i + 1, 3 * i + 2};
        }
        rtcSetGeometryIntersectFilterFunction(geometry, filter);
        rtcSetGeometryOccludedFilterFunction(geometry, filter);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene_);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
        throw std::runtime_error("Embree could not build the acceleration structure");
    }
}

EmbreeBvh::~EmbreeBvh() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

std::optional<Hit> EmbreeBvh::intersect(const Ray& ray) const {
    if (!finite(ray.origin) || !finite(ray.direction)) return std::nullopt;
    FilteredQuery filtered{{}, &accepts_, ray.originTriangle};
    RTCRayHit query{};
    query.ray = embreeRay(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    embree::intersect(scene_, filtered.context, query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return Hit{query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID};
}

bool EmbreeBvh::occluded(const Ray& ray) const {
    if (!finite(ray.origin) || !finite(ray.direction)) return false;
    FilteredQuery filtered{{}, &accepts_, ray.originTriangle};
    RTCRay query = embreeRay(ray);
    embree::occluded(scene_, filtered.context, query);
    return query.tfar < 0.0f;
}

}  // namespace clerestory::reference
