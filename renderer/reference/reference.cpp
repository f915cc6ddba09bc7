// Checks the request, distributes tiles to threads, and estimates noise from the two halves of the
// samples.
#include "reference/reference.h"

#include "plan/planner.h"
#include "plan/request/view_settings.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/view.h"
#include "reference/path.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace clerestory {
namespace {

using namespace reference;

// Camera rays of a View, computed independently of the renderer's projection code.
struct CameraRay {
    glm::dvec3 origin{0.0};         // relative to the eye, world axes; 0 for perspective views
    glm::dvec3 direction{0.0};      // unit
    double tMin = 0.0, tMax = 0.0;  // metres
};

class RayCamera {
public:
    // lens: see requestedLens(); must outlive the camera.
    RayCamera(const View& view, const Lens* lens, std::uint32_t width, std::uint32_t height);

    // The ray through image position (x, y), in pixels from the upper left corner; none outside of
    // the picture of the lens.
    std::optional<CameraRay> generateRay(double x, double y) const;

private:
    const Lens* lens_ = nullptr;
    glm::dmat3 worldFromCamera_;
    glm::dvec2 scale_{1.0}, shift_{0.0};  // slopes (orthographic: metres) at the image's edges
    glm::dvec2 size_{1.0};
    bool orthographic_ = false;
    double znear_ = 0.0, zfar_ = 0.0;
};

// With m = clipFromView, normalised x is m00 x/w - m20, w = -z, for perspective and m00 x + m30 for
// orthographic views. Depth is reversed: m22 is near / (far - near) and 1 / (far - near).
RayCamera::RayCamera(const View& view, const Lens* lens, std::uint32_t width, std::uint32_t height)
    : lens_(lens),
      worldFromCamera_(glm::transpose(glm::dmat3(view.viewFromWorld))),
      size_(width, height),
      orthographic_(view.orthographic),
      znear_(view.znear) {
    const glm::dmat4& m = view.clipFromView;
    scale_ = {1.0 / m[0][0], 1.0 / m[1][1]};
    shift_ = orthographic_ ? glm::dvec2(-m[3][0], -m[3][1]) : glm::dvec2(m[2][0], m[2][1]);
    const double depth = m[2][2];
    zfar_ = !(depth > 0.0)  ? std::numeric_limits<double>::infinity()
            : orthographic_ ? znear_ + 1.0 / depth
                            : znear_ * (1.0 + 1.0 / depth);
}

std::optional<CameraRay> RayCamera::generateRay(double x, double y) const {
    if (lens_) {
        const auto direction = rayOf(*lens_, {x, y});
        if (!direction) return std::nullopt;
        const double perDepth = 1.0 / depthPerDistance(*lens_, *direction);
        return CameraRay{glm::dvec3(0.0), worldFromCamera_ * *direction, znear_ * perDepth,
                         zfar_ * perDepth};
    }
    const glm::dvec2 ndc(2.0 * x / size_.x - 1.0, 1.0 - 2.0 * y / size_.y);
    const glm::dvec2 at = (ndc + shift_) * scale_;
    if (orthographic_) {
        return CameraRay{worldFromCamera_ * glm::dvec3(at, 0.0), -worldFromCamera_[2], znear_,
                         zfar_};
    }
    const glm::dvec3 direction(at, -1.0);
    const double perDepth = glm::length(direction);
    return CameraRay{glm::dvec3(0.0), worldFromCamera_ * (direction / perDepth), znear_ * perDepth,
                     zfar_ * perDepth};
}

void check(const ReferenceRequest& r) {
    if (std::vector<FieldError> errors = problems(r.frame); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    if (std::vector<FieldError> errors = problems(r.scene, r.frame.overrides); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    if (std::vector<FieldError> errors = problems(r.scene, r.frame.lights); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    if (std::vector<FieldError> errors = problems(r.scene, r.frame.nodes); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    if (!clipsNamed(r.scene, r.frame.clip)) throw InvalidRequest({unknownClip(r.scene)});
    if (!hasVariant(r.scene, r.frame.variant)) throw InvalidRequest({unknownVariant(r.scene)});
    if (r.samples < 2 || r.samples > kMaxReferenceSamples) {
        throw std::invalid_argument("samples must be 2 to " + std::to_string(kMaxReferenceSamples));
    }
    if (r.threads > kMaxReferenceThreads) {
        throw std::invalid_argument("threads must not exceed " +
                                    std::to_string(kMaxReferenceThreads));
    }
}

FirstHit firstHitOf(const Surface& surface) {
    if (surface.glass != Glass::none) return FirstHit::glass;
    if (surface.reflector == Reflector::flat) return FirstHit::flatMirror;
    return surface.reflector == Reflector::curved ? FirstHit::curvedMirror : FirstHit::surface;
}

// Traces pixels independently of each other.
class TiledImage {
public:
    TiledImage(const SceneGeometry& geometry, const PathTracer& tracer, const View& view,
               const std::optional<Lens>& lens, const ReferenceRequest& request)
        : geometry_(geometry),
          tracer_(tracer),
          camera_(view, lens ? &*lens : nullptr, request.frame.width, request.frame.height),
          lensEdges_(lens.has_value()),
          eye_(view.eye - geometry.origin()),
          seed_(request.seed),
          samplesPerHalf_((request.samples + 1) / 2) {
        const std::uint32_t width = request.frame.width, height = request.frame.height;
        result_.color = makeImage(width, height, 3, PixelType::float32);
        result_.noise = makeImage(width, height, 3, PixelType::float32);
        result_.objectId.resize(std::size_t{width} * height);
        result_.firstHit.resize(std::size_t{width} * height);
        result_.samples = 2 * samplesPerHalf_;
    }

    std::size_t tiles() const { return std::size_t{tilesAlong(width())} * tilesAlong(height()); }

    // Returns false if `cancelled` became true before the tile was complete.
    bool traceTile(std::size_t tile, const std::atomic<bool>& cancelled) {
        const std::uint32_t columns = tilesAlong(width());
        const auto left = static_cast<std::uint32_t>(tile % columns) * kTile;
        const auto top = static_cast<std::uint32_t>(tile / columns) * kTile;
        for (std::uint32_t y = top; y < std::min(top + kTile, height()); ++y) {
            for (std::uint32_t x = left; x < std::min(left + kTile, width()); ++x) {
                if (!tracePixel(x, y, cancelled)) return false;
            }
        }
        return true;
    }

    ReferenceImage takeResult() {
        const std::size_t values = 3 * result_.objectId.size();
        double sum = 0.0;
        for (std::size_t i = 0; i < values; ++i) {
            sum += double(result_.noise.floats()[i]) * result_.noise.floats()[i];
        }
        result_.noiseFloor = std::sqrt(sum / double(values));
        result_.nonFinite = nonFinite_;
        return std::move(result_);
    }

private:
    static constexpr std::uint32_t kTile = 8;  // pixels

    static std::uint32_t tilesAlong(std::uint32_t pixels) { return (pixels + kTile - 1) / kTile; }
    std::uint32_t width() const { return result_.color.width; }
    std::uint32_t height() const { return result_.color.height; }

    std::optional<Ray> rayThrough(double x, double y) const {
        const std::optional<CameraRay> ray = camera_.generateRay(x, y);
        if (!ray) return std::nullopt;
        return Ray{.origin = eye_ + ray->origin,
                   .direction = ray->direction,
                   .tMin = ray->tMin,
                   .tMax = ray->tMax};
    }

    // Each sample represents the area of four, so that footprints overlap.
    PixelFootprint footprintOf(const Ray& ray, const Ray& next) const {
        const double fraction = std::min(1.0, 2.0 / std::sqrt(double(result_.samples)));
        return {fraction, fraction * glm::length(next.direction - ray.direction),
                fraction * glm::length(next.origin - ray.origin)};
    }

    // Of the pixel: from its centre to that of a neighbour that the lens shows nearby.
    PixelFootprint footprintAt(std::uint32_t x, std::uint32_t y) const {
        const std::optional<Ray> central = rayThrough(x + 0.5, y + 0.5);
        if (!central) return footprintOf({}, {});
        const std::optional<Ray> next = rayThrough(x + 1.5, y + 0.5);
        const std::optional<Ray> last = lensEdges_ ? rayThrough(x - 0.5, y + 0.5) : std::nullopt;
        const auto distance = [&](const std::optional<Ray>& ray) {
            return ray ? glm::length(ray->direction - central->direction) : INFINITY;
        };
        const std::optional<Ray>& nearer = distance(last) < distance(next) ? last : next;
        return footprintOf(*central, nearer.value_or(*central));
    }

    bool tracePixel(std::uint32_t x, std::uint32_t y, const std::atomic<bool>& cancelled) {
        const std::size_t pixel = std::size_t{y} * width() + x;
        const std::optional<Ray> central = rayThrough(x + 0.5, y + 0.5);
        if (const auto hit = central ? geometry_.intersect(*central) : std::nullopt) {
            const SurfaceInteraction p = geometry_.interactionAt(*hit, central->direction);
            result_.objectId[pixel] = p.instance + 1;
            result_.firstHit[pixel] = firstHitOf(*p.surface);
        }
        const PixelFootprint footprint = footprintAt(x, y);
        glm::dvec3 halves[2] = {glm::dvec3(0.0), glm::dvec3(0.0)};
        for (int half = 0; half < 2; ++half) {
            for (std::uint32_t i = 0; i < samplesPerHalf_; ++i) {
                if (cancelled.load(std::memory_order_relaxed)) return false;
                Sampler sampler(seed_, 2 * pixel + half, i);
                const glm::dvec2 offset = sampler.get2D();
                const std::optional<Ray> ray = rayThrough(x + offset.x, y + offset.y);
                if (!ray) continue;  // black
                const glm::dvec3 sample = tracer_.radiance(*ray, sampler, footprint);
                if (finite(sample))
                    halves[half] += sample;
                else
                    ++nonFinite_;
            }
            halves[half] /= double(samplesPerHalf_);
        }
        for (int c = 0; c < 3; ++c) {
            result_.color.floats()[3 * pixel + c] = float(0.5 * (halves[0][c] + halves[1][c]));
            result_.noise.floats()[3 * pixel + c] =
                float(0.5 * std::abs(halves[0][c] - halves[1][c]));
        }
        return true;
    }

    const SceneGeometry& geometry_;
    const PathTracer& tracer_;
    RayCamera camera_;
    bool lensEdges_;  // the next pixel may show something else, or nothing
    glm::dvec3 eye_;
    std::uint64_t seed_;
    std::uint32_t samplesPerHalf_;
    ReferenceImage result_;
    std::atomic<std::uint64_t> nonFinite_ = 0;
};

// Distributes tiles to threads. Returns false if `progress` returned false before all were traced.
bool traceAll(TiledImage& image, std::uint32_t threads,
              const std::function<bool(double)>& progress) {
    const std::size_t tiles = image.tiles();
    std::atomic<std::size_t> next = 0, done = 0;
    std::atomic<bool> cancelled = false;
    std::mutex mutex;
    std::condition_variable changed;
    std::uint32_t working = threads;
    const auto work = [&] {
        for (std::size_t tile; !cancelled && (tile = next++) < tiles;) {
            if (image.traceTile(tile, cancelled)) ++done;
        }
        const std::scoped_lock lock(mutex);
        --working;
        changed.notify_all();
    };
    std::vector<std::jthread> pool;
    for (std::uint32_t i = 0; i < threads; ++i) pool.emplace_back(work);

    const auto report = [&] {
        return !progress || progress(double(done) / double(std::max<std::size_t>(tiles, 1)));
    };
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, std::chrono::milliseconds(100), [&] { return working == 0; })) {
        lock.unlock();
        if (!cancelled && !report()) cancelled = true;
        lock.lock();
    }
    lock.unlock();
    if (!cancelled && !report()) cancelled = true;
    return !cancelled;
}

Lighting lightingOf(const ReferenceRequest& request, const Pose& pose, const glm::dvec3& origin,
                    const glm::dmat3& worldFromMap) {
    const double intensity = request.frame.environment.intensity;
    Lighting lighting{.environment = {request.environment, worldFromMap, intensity},
                      .lights = collectPunctualLights(
                          lightsWith(lightsOf(request.scene, pose), request.frame.lights), pose,
                          origin, request.environment, worldFromMap, intensity),
                      .backgroundVisible = request.frame.environment.visible};
    if (request.mode == ReferenceMode::effects)
        lighting.environment.prepareIrradiance();
    else
        lighting.environment.prepareSampling();
    for (const auto& [name, map] : request.maps) {
        lighting.named.try_emplace(name, *map, glm::dmat3(1.0), intensity);
    }
    return lighting;
}

}  // namespace

std::optional<ReferenceImage> traceReference(const ReferenceRequest& request,
                                             const std::function<bool(double)>& progress) {
    check(request);
    FrameRequest frame = request.frame;
    frame.background.reset();  // the ground is a surface
    const Composition composition = compositionOf(frame);
    if (!composition.empty()) {
        const Scene scene = composed(request.scene, composition);
        frame.nodes.clear();
        frame.ground.reset();
        return traceReference({.scene = scene,
                               .frame = frame,
                               .environment = request.environment,
                               .maps = request.maps,
                               .mode = request.mode,
                               .samples = request.samples,
                               .seed = request.seed,
                               .threads = request.threads},
                              progress);
    }
    if (progress && !progress(0.0)) return std::nullopt;
    const Pose pose = poseAt(request.scene, *clipsNamed(request.scene, frame.clip), frame.time);
    const View view = requestedView(frame.camera, request.scene, pose, frame.width, frame.height);
    const std::optional<Lens> lens =
        requestedLens(frame.camera, request.scene, pose, frame.width, frame.height);
    const MaterialBindings materials =
        bindMaterials(request.scene, pose, frame.overrides, frame.variant);

    const SceneGeometry geometry(request.scene, pose, materials, frame.effects);
    const Lighting lighting =
        lightingOf(request, pose, geometry.origin(), worldFromMap(frame, request.scene));
    const PathTracer tracer(geometry, lighting, frame.effects, request.mode);

    const std::uint32_t threads =
        request.threads > 0 ? request.threads : std::max(1u, std::thread::hardware_concurrency());
    TiledImage image(geometry, tracer, view, lens, request);
    if (!traceAll(image, std::min(threads, kMaxReferenceThreads), progress)) {
        return std::nullopt;
    }
    return image.takeResult();
}

}  // namespace clerestory
