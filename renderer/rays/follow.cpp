#include "rays/follow.h"

#include "image/bands.h"
#include "rays/glsl.h"
#include "shaders/include/bindings.glsl"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <atomic>
#include <vector>

namespace clerestory::rays {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace shader {
namespace {

using namespace clerestory::rays::glsl;

// ---- what the includes read
// ----------------------------------------------------------------------

struct Rows {
    const float* data = nullptr;
};
struct Pairs {
    const float* data = nullptr;
};
struct Integers {
    const std::uint32_t* data = nullptr;
};
struct Texels {
    const std::byte* data = nullptr;
};
struct Triangles {
    const TriangleTree* tree = nullptr;
};
struct Plane {
    const float* data = nullptr;  // two floats each
    int size = 0;
};
struct Cube {
    const CubeMap* map = nullptr;
};

struct Scene {
    struct {
        vec4 worldFromEye[3];
        vec4 environment;
    } viewBlock;
    struct {
        vec4 eye, limits;
    } tracingBlock;
    std::uint32_t features;
    Triangles triangles;
    Pairs vertices;
    Integers indices;
    Rows instances, materials, lights;
    Texels texels;
    Plane brdf;
    Cube environment;
};
thread_local const Scene* scene = nullptr;

vec4 texelFetch(Rows table, int i) {
    const float* row = table.data + std::size_t{4} * static_cast<std::size_t>(i);
    return {row[0], row[1], row[2], row[3]};
}
vec4 texelFetch(Pairs table, int i) {
    const float* pair = table.data + std::size_t{2} * static_cast<std::size_t>(i);
    return {pair[0], pair[1], 0.0f, 1.0f};
}
struct uvec4 {
    uint x;
};
uvec4 texelFetch(Integers table, int i) {
    return {table.data[i]};
}
vec4 texelFetch(Texels table, int i) {
    const auto* t = reinterpret_cast<const std::uint8_t*>(table.data) +
                    std::size_t{4} * static_cast<std::size_t>(i);
    constexpr float k = 1.0f / 255.0f;
    return {k * t[0], k * t[1], k * t[2], k * t[3]};
}
vec4 texelFetch(Triangles table, int row) {
    const auto place =
        static_cast<std::uint32_t>(row) / static_cast<std::uint32_t>(TRACE_TRIANGLE_ROWS);
    const auto* rows = reinterpret_cast<const float*>(&table.tree->triangle(place));
    return texelFetch(Rows{rows}, row - TRACE_TRIANGLE_ROWS * static_cast<int>(place));
}
// Bilinear, clamped to the edge.
vec4 textureLod(Plane plane, vec2 at, float) {
    const auto size = static_cast<float>(plane.size);
    const vec2 p = clamp(at * size - vec2(0.5f), vec2(0.0f), vec2(size - 1.0f));
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    const int x1 = min(x + 1, plane.size - 1), y1 = min(y + 1, plane.size - 1);
    const auto texel = [&](int i, int j) {
        const float* t = plane.data + 2 * (j * plane.size + i);
        return vec2(t[0], t[1]);
    };
    const float fx = p.x - static_cast<float>(x), fy = p.y - static_cast<float>(y);
    const vec2 value =
        mix(mix(texel(x, y), texel(x1, y), fx), mix(texel(x, y1), texel(x1, y1), fx), fy);
    return {value.x, value.y, 0.0f, 1.0f};
}
vec4 textureLod(Cube cube, vec3 towards, float level) {
    float rgb[3];
    cube.map->sample(&towards.x, level, rgb);
    return {rgb[0], rgb[1], rgb[2], 1.0f};
}

// In the place of trace.glsl.
struct Hit {
    float distance;
    int place;
    vec2 weights;
};
Hit traceClosest(vec3 origin, vec3 direction, float, float) {
    TriangleHit hit;
    if (!scene->triangles.tree->nearestHit(&origin.x, &direction.x, hit)) {
        return {1e30f, -1, vec2(0.0f)};
    }
    return {hit.distance, static_cast<int>(hit.place), vec2(hit.u, hit.v)};
}

// Of the path that the thread follows (FNV-1a).
thread_local std::uint32_t surfaces = 0;
void noteHit(int instance) {
    surfaces = (surfaces ^ static_cast<std::uint32_t>(instance)) * 16777619u;
}

// ---- the includes
// --------------------------------------------------------------------------------

#define view (scene->viewBlock)
#define tracing (scene->tracingBlock)
#define VARIANT (scene->features)
#define traceTriangles (scene->triangles)
#define traceVertices (scene->vertices)
#define traceIndices (scene->indices)
#define traceInstances (scene->instances)
#define traceMaterials (scene->materials)
#define traceTexels (scene->texels)
#define lightTable (scene->lights)
#define environmentBrdf (scene->brdf)
#define environmentMap (scene->environment)
#define xy asXy()
#define rg asXy()
#define yz asYz()
#define zw asZw()
#define bg asBg()
#define ra asRa()
#define xyz asXyz()
#define rgb asXyz()
#define yzw asYzw()
// clang-format off
#include "include/features.glsl"
#include "include/optics.glsl"
#include "include/sampling.glsl"
#include "include/material_point.glsl"
#include "include/glass.glsl"
#include "include/lighting.glsl"
#include "include/ray.glsl"
#include "include/hit.glsl"
#include "include/ray_path.glsl"
// clang-format on
#undef view
#undef tracing
#undef xy
#undef rg
#undef yz
#undef zw
#undef bg
#undef ra
#undef xyz
#undef rgb
#undef yzw

// The inverse of octahedral() in ray_record.glsl.
vec3 directionOf(const Way& way) {
    const vec2 p(way.octahedral[0], way.octahedral[1]);
    vec3 v(p.x, p.y, 1.0f - abs(p.x) - abs(p.y));
    if (v.z < 0.0f) {
        v.x = (1.0f - abs(p.y)) * (p.x >= 0.0f ? 1.0f : -1.0f);
        v.y = (1.0f - abs(p.x)) * (p.y >= 0.0f ? 1.0f : -1.0f);
    }
    return normalize(v);
}

vec2 halves(std::uint32_t packed) {
    const glm::vec2 v = glm::unpackHalf2x16(packed);
    return {v.x, v.y};
}

struct Ray {
    vec3 start, along, share;
    RayCone cone;
};
Ray rayOf(const Start& start, const Way& way) {
    const vec2 cone = halves(start.cone);
    const vec2 redGreen = halves(way.shareRedGreen), blueLobe = halves(way.shareBlueLobe);
    return {vec3(start.place[0], start.place[1], start.place[2]), directionOf(way),
            vec3(redGreen.x, redGreen.y, blueLobe.x), RayCone(exp2(cone.y), cone.x, blueLobe.y)};
}

Path pathOf(const Ray& ray) {
    surfaces = 2166136261u;
    const vec3 radiance =
        radianceFinite(tracedRadiance(ray.start, ray.along, ray.cone, maxComponent(ray.share)));
    return {{radiance.x, radiance.y, radiance.z}, surfaces | 1u};
}

}  // namespace
}  // namespace shader
#pragma GCC diagnostic pop

namespace {

const float* floatsOf(std::span<const glm::vec4> rows) {
    return rows.empty() ? nullptr : &rows.front().x;
}

shader::Scene sceneOf(const Surroundings& s) {
    shader::Scene scene{};
    for (int row = 0; row < 3; ++row) {
        scene.viewBlock.worldFromEye[row] = {s.worldFromEye[0][row], s.worldFromEye[1][row],
                                             s.worldFromEye[2][row], 0.0f};
    }
    scene.viewBlock.environment = {static_cast<float>(s.environment.levels()) - 1.0f,
                                   s.environmentIntensity, 0.0f, 0.0f};
    scene.tracingBlock.eye = {s.eye.x, s.eye.y, s.eye.z, 0.0f};
    scene.tracingBlock.limits = {static_cast<float>(s.bounces),
                                 static_cast<float>(s.firstTextureRow), s.leastShare, 0.0f};
    scene.features = s.hitFeatures;
    scene.triangles = {&s.tree};
    scene.vertices = {s.vertices.empty() ? nullptr : &s.vertices.front().position.x};
    scene.indices = {s.indices.data()};
    scene.instances = {floatsOf(s.instances)};
    scene.materials = {floatsOf(s.materials)};
    scene.lights = {floatsOf(s.lights)};
    scene.texels = {s.texels.data()};
    scene.brdf = {s.brdf.empty() ? nullptr : &s.brdf.front().x, static_cast<int>(s.brdfSize)};
    scene.environment = {&s.environment};
    return scene;
}

// Runs work(first, end) for parts of the rows on all processors.
template <class Work>
void inParallel(std::uint32_t rows, const shader::Scene& scene, const Work& work) {
    constexpr std::uint32_t kRowsAtOnce = 8;
    forEachBand(rows, kRowsAtOnce, [&](std::uint32_t first, std::uint32_t end) {
        shader::scene = &scene;
        work(first, end);
        shader::scene = nullptr;
    });
}

// The rays of one list, and what is known of their paths so far.
struct Paths {
    const Density& density;
    std::uint32_t width, height;
    std::span<const Start> starts;
    std::span<const Way> ways;
    Scratch& paths;

    std::size_t at(std::uint32_t x, std::uint32_t y) const { return std::size_t{y} * width + x; }

    // Sets `mean` to the mean of the neighbours at a distance of `step` whose paths are known,
    // to the left and right, above and below, or in the diagonals. Returns false if they do not
    // agree. before: light that the pixel has already.
    bool agree(std::uint32_t x, std::uint32_t y, std::uint32_t step, const shader::Ray& ray,
               const glm::vec3& before, Path& mean) const {
        const std::uint32_t dx = x % (2 * step) != 0 ? step : 0,
                            dy = y % (2 * step) != 0 ? step : 0;
        if (x < dx || y < dy || x + dx >= width || y + dy >= height) return false;
        const std::size_t neighbours[4] = {at(x - dx, y - dy), at(x + dx, y + dy),
                                           at(x - dx, y + dy), at(x + dx, y - dy)};
        const int count = dx != 0 && dy != 0 ? 4 : 2;
        glm::vec3 low(1e30f), high(0.0f), sum(0.0f), place(0.0f);
        for (int i = 0; i < count; ++i) {
            const Path& path = paths[neighbours[i]];
            if (path.surfaces == 0 || path.surfaces != paths[neighbours[0]].surfaces) return false;
            const glm::vec3 radiance(path.radiance[0], path.radiance[1], path.radiance[2]);
            low = glm::min(low, radiance);
            high = glm::max(high, radiance);
            sum += radiance;
            const float* p = starts[neighbours[i]].place;
            place += glm::vec3(p[0], p[1], p[2]);
        }
        sum /= static_cast<float>(count);
        // The ray starts between those of its neighbours, not at another surface.
        place =
            place / static_cast<float>(count) - glm::vec3(ray.start.x, ray.start.y, ray.start.z);
        const float reach = 2.0f * static_cast<float>(step) * ray.cone.width;
        if (glm::dot(place, place) > reach * reach) return false;
        const glm::vec3 share(ray.share.x, ray.share.y, ray.share.z);
        const glm::vec3 difference = share * (high - low), seen = before + share * sum;
        const float allowed = density.contrast * (std::max({seen.x, seen.y, seen.z}) + 0.02f);
        if (std::max({difference.x, difference.y, difference.z}) > allowed) return false;
        mean = {{sum.x, sum.y, sum.z}, paths[neighbours[0]].surfaces};
        return true;
    }
};

}  // namespace

std::uint64_t follow(const Surroundings& surroundings, const Density& density, std::uint32_t width,
                     std::span<const Start> starts, std::span<const Way> ways,
                     std::span<const Earlier> earlier, std::span<glm::vec4> radiance,
                     Scratch& scratch) {
    const shader::Scene scene = sceneOf(surroundings);
    scratch.resize(std::max(scratch.size(), starts.size()));
    const auto height = static_cast<std::uint32_t>(starts.size() / std::max(1u, width));
    Paths list{density, width, height, starts, ways, scratch};
    std::atomic<std::uint64_t> followed{0};
    // The first step follows the ray of each place of the grid; the others fill the grid between.
    for (std::uint32_t step = density.stride; step >= 1; step /= 2) {
        const bool first = step == density.stride;
        inParallel((height + step - 1) / step, scene, [&](std::uint32_t row, std::uint32_t end) {
            std::uint64_t count = 0;
            for (; row < end; ++row) {
                const std::uint32_t y = row * step;
                for (std::uint32_t x = 0; x < width; x += step) {
                    if (!first && x % (2 * step) == 0 && y % (2 * step) == 0) continue;
                    const std::size_t i = list.at(x, y);
                    scratch[i].surfaces = 0;
                    if (!starts[i].present()) continue;
                    const shader::Ray ray = shader::rayOf(starts[i], ways[i]);
                    Path path{};
                    const auto same =
                        std::find_if(earlier.begin(), earlier.end(),
                                     [&](const Earlier& e) { return e.starts[i] == starts[i]; });
                    if (same != earlier.end()) {
                        path = same->paths[i];
                    } else if (first ||
                               !list.agree(x, y, step, ray, glm::vec3(radiance[i]), path)) {
                        path = shader::pathOf(ray);
                        ++count;
                    }
                    scratch[i] = path;
                    radiance[i] +=
                        glm::vec4(ray.share.x * path.radiance[0], ray.share.y * path.radiance[1],
                                  ray.share.z * path.radiance[2], 0.0f);
                }
            }
            followed += count;
        });
    }
    return followed;
}

}  // namespace clerestory::rays
