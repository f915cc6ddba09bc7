#include "rays/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <stdexcept>

namespace clerestory::rays {
namespace {

// Embree calls this for every triangle along a ray that could be its hit. The user data is the side
// of all triangles of the geometry, as BvhTriangle::side.
void rejectBacks(const RTCFilterFunctionNArguments* args) {
    const float side = *static_cast<const float*>(args->geometryUserPtr);
    for (unsigned lane = 0; lane < args->N; ++lane) {
        if (args->valid[lane] == 0) continue;
        const float against =
            RTCHitN_Ng_x(args->hit, args->N, lane) * RTCRayN_dir_x(args->ray, args->N, lane) +
            RTCHitN_Ng_y(args->hit, args->N, lane) * RTCRayN_dir_y(args->ray, args->N, lane) +
            RTCHitN_Ng_z(args->hit, args->N, lane) * RTCRayN_dir_z(args->ray, args->N, lane);
        if (side * against > 0.0f) args->valid[lane] = 0;
    }
}

constexpr float kSides[] = {0.0f, 1.0f, -1.0f};

// Corners are read in place: as an array of vectors of four floats, a triangle is three of them.
constexpr std::size_t kCornerBytes = 4 * sizeof(float);
static_assert(offsetof(BvhTriangle, b) == kCornerBytes &&
              offsetof(BvhTriangle, c) == 2 * kCornerBytes &&
              sizeof(BvhTriangle) == 3 * kCornerBytes);

// Adds the triangles, which must outlive `scene`, as a geometry with the given number.
void attach(RTCDevice device, RTCScene scene, RTCBuildQuality quality, unsigned number,
            std::span<const BvhTriangle> triangles) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality);
    const std::size_t count = triangles.size();
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               triangles.data(), 0, kCornerBytes, 3 * count);
    auto* indices = static_cast<std::array<std::uint32_t, 3>*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                sizeof(std::array<std::uint32_t, 3>), count));
    for (std::uint32_t i = 0; indices && i < count; ++i) {
        indices[i] = {3 * i, 3 * i + 1, 3 * i + 2};
    }
    if (kSides[number] != 0.0f) {
        rtcSetGeometryUserData(geometry, const_cast<float*>(&kSides[number]));
        rtcSetGeometryIntersectFilterFunction(geometry, rejectBacks);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, number);
    rtcReleaseGeometry(geometry);
}

}  // namespace

TriangleTree::TriangleTree() : device_(rtcNewDevice("threads=1,set_affinity=0")) {
    if (!device_) throw std::runtime_error("Embree could not create a device");
}

TriangleTree::~TriangleTree() {
    for (Part* part : {&still_, &moving_}) {
        if (part->scene) rtcReleaseScene(part->scene);
    }
    rtcReleaseDevice(device_);
}

void TriangleTree::build(Part& part, std::vector<BvhTriangle> triangles, RTCBuildQuality quality) {
    if (part.scene) rtcReleaseScene(part.scene);
    part.scene = nullptr;
    part.triangles = std::move(triangles);
    if (part.triangles.empty()) return;
    // One geometry a side: the filter then reads nothing of the triangle.
    std::stable_sort(part.triangles.begin(), part.triangles.end(),
                     [](const BvhTriangle& a, const BvhTriangle& b) {
                         return std::find(std::begin(kSides), std::end(kSides), a.side) <
                                std::find(std::begin(kSides), std::end(kSides), b.side);
                     });
    part.scene = rtcNewScene(device_);
    rtcSetSceneFlags(part.scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(part.scene, quality);
    auto first = part.triangles.begin();
    for (unsigned number = 0; number < std::size(kSides); ++number) {
        const auto end = std::find_if(first, part.triangles.end(), [&](const BvhTriangle& t) {
            return t.side != kSides[number];
        });
        part.first[number] = static_cast<std::uint32_t>(first - part.triangles.begin());
        if (first != end) attach(device_, part.scene, quality, number, {first, end});
        first = end;
    }
    rtcCommitScene(part.scene);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) {
        throw std::runtime_error("Embree could not build the hierarchy of the scene");
    }
}

void TriangleTree::setStill(std::vector<BvhTriangle> triangles) {
    build(still_, std::move(triangles), RTC_BUILD_QUALITY_MEDIUM);
}

void TriangleTree::setMoving(std::vector<BvhTriangle> triangles) {
    build(moving_, std::move(triangles), RTC_BUILD_QUALITY_LOW);
}

std::uint64_t TriangleTree::bytes() const {
    // Embree: 12 bytes of indices and about 64 of nodes and leaves a triangle.
    return (still_.triangles.size() + moving_.triangles.size()) * (sizeof(BvhTriangle) + 76);
}

bool TriangleTree::nearestHit(const float origin[3], const float direction[3],
                              TriangleHit& hit) const {
    RTCRayHit query{};
    query.ray.org_x = origin[0];
    query.ray.org_y = origin[1];
    query.ray.org_z = origin[2];
    query.ray.dir_x = direction[0];
    query.ray.dir_y = direction[1];
    query.ray.dir_z = direction[2];
    query.ray.tfar = 1e30f;
    query.ray.mask = 0xffffffffu;
    const float sum =
        origin[0] + origin[1] + origin[2] + direction[0] + direction[1] + direction[2];
    if (!std::isfinite(sum)) return false;
    bool found = false;
    std::uint32_t before = 0;  // triangles of earlier parts
    for (const Part* part : {&still_, &moving_}) {
        if (part->scene) {
            embree::QueryContext context;
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            embree::intersect(part->scene, context, query);
            if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
                hit = {query.ray.tfar, before + part->first[query.hit.geomID] + query.hit.primID,
                       query.hit.u, query.hit.v};
                found = true;
            }
        }
        before += static_cast<std::uint32_t>(part->triangles.size());
    }
    return found;
}

}  // namespace clerestory::rays
