// From a request to a picture: what to trace, pixels to threads, two halves to a noise floor.
#include "reference/reference.h"

#include "plan/effects/lighting.h"
#include "plan/planner.h"
#include "plan/visibility/view.h"
#include "reference/camera.h"
#include "reference/path.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace clerestory {
namespace {

using namespace reference;

void check(const ReferenceRequest& r) {
    if (std::vector<FieldError> errors = problems(r.frame); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    if (std::vector<FieldError> errors = problems(r.scene, r.frame.overrides); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    if (!clipsNamed(r.scene, r.frame.clip)) throw InvalidRequest({noSuchClip(r.scene)});
    if (r.samples < 2 || r.samples > kMaxReferenceSamples) {
        throw std::invalid_argument("samples must be 2 to " + std::to_string(kMaxReferenceSamples));
    }
    if (r.threads > kMaxReferenceThreads) {
        throw std::invalid_argument("threads must be at most " +
                                    std::to_string(kMaxReferenceThreads));
    }
}

FirstHit kindOf(const Surface& surface) {
    if (surface.glass != Glass::none) return FirstHit::glass;
    if (surface.reflector == Reflector::flat) return FirstHit::flatMirror;
    return surface.reflector == Reflector::curved ? FirstHit::curvedMirror : FirstHit::surface;
}

// The pixels of a picture, each on its own.
class Picture {
public:
    Picture(const World& world, const PathTracer& tracer, const View& view,
            const ReferenceRequest& request)
        : world_(world),
          tracer_(tracer),
          lens_(view, request.frame.width, request.frame.height),
          eye_(view.eye - world.origin()),
          seed_(request.seed),
          perHalf_((request.samples + 1) / 2) {
        const std::uint32_t width = request.frame.width, height = request.frame.height;
        result_.color = makeImage(width, height, 3, PixelType::float32);
        result_.noise = makeImage(width, height, 3, PixelType::float32);
        result_.objectId.resize(std::size_t{width} * height);
        result_.firstHit.resize(std::size_t{width} * height);
        result_.samples = 2 * perHalf_;
    }

    std::size_t tiles() const { return std::size_t{across(width())} * across(height()); }

    // False when `cancelled` became true before it was done.
    bool traceTile(std::size_t tile, const std::atomic<bool>& cancelled) {
        const std::uint32_t columns = across(width());
        const auto left = static_cast<std::uint32_t>(tile % columns) * kTile;
        const auto top = static_cast<std::uint32_t>(tile / columns) * kTile;
        for (std::uint32_t y = top; y < std::min(top + kTile, height()); ++y) {
            for (std::uint32_t x = left; x < std::min(left + kTile, width()); ++x) {
                if (!tracePixel(x, y, cancelled)) return false;
            }
        }
        return true;
    }

    ReferenceImage finished() {
        const std::size_t numbers = 3 * result_.objectId.size();
        double sum = 0.0;
        for (std::size_t i = 0; i < numbers; ++i) {
            sum += double(result_.noise.floats()[i]) * result_.noise.floats()[i];
        }
        result_.noiseFloor = std::sqrt(sum / double(numbers));
        result_.nonFinite = nonFinite_;
        return std::move(result_);
    }

private:
    static constexpr std::uint32_t kTile = 8;  // pixels

    static std::uint32_t across(std::uint32_t pixels) { return (pixels + kTile - 1) / kTile; }
    std::uint32_t width() const { return result_.color.width; }
    std::uint32_t height() const { return result_.color.height; }

    Ray rayThrough(double x, double y) const {
        const CameraRay ray = lens_.through(x, y);
        return {.origin = eye_ + ray.origin,
                .direction = ray.direction,
                .nearest = ray.nearest,
                .farthest = ray.farthest};
    }

    // What each sample stands for: as much of the pixel as four samples do, so that they overlap.
    PixelShare shareOf(const Ray& ray, const Ray& next) const {
        const double edge = std::min(1.0, 2.0 / std::sqrt(double(result_.samples)));
        return {edge, edge * glm::length(next.direction - ray.direction),
                edge * glm::length(next.origin - ray.origin)};
    }

    bool tracePixel(std::uint32_t x, std::uint32_t y, const std::atomic<bool>& cancelled) {
        const std::size_t pixel = std::size_t{y} * width() + x;
        const Ray central = rayThrough(x + 0.5, y + 0.5);
        if (const auto hit = world_.nearest(central)) {
            const Point p = world_.pointAt(*hit, central.direction);
            result_.objectId[pixel] = p.instance + 1;
            result_.firstHit[pixel] = kindOf(*p.surface);
        }
        const PixelShare share = shareOf(central, rayThrough(x + 1.5, y + 0.5));
        glm::dvec3 halves[2] = {glm::dvec3(0.0), glm::dvec3(0.0)};
        for (int half = 0; half < 2; ++half) {
            for (std::uint32_t i = 0; i < perHalf_; ++i) {
                if (cancelled.load(std::memory_order_relaxed)) return false;
                Random random(seed_, 2 * pixel + half, i);
                const glm::dvec2 at = random.pair();
                const glm::dvec3 sample =
                    tracer_.radiance(rayThrough(x + at.x, y + at.y), random, share);
                if (finite(sample))
                    halves[half] += sample;
                else
                    ++nonFinite_;
            }
            halves[half] /= double(perHalf_);
        }
        for (int c = 0; c < 3; ++c) {
            result_.color.floats()[3 * pixel + c] = float(0.5 * (halves[0][c] + halves[1][c]));
            result_.noise.floats()[3 * pixel + c] =
                float(0.5 * std::abs(halves[0][c] - halves[1][c]));
        }
        return true;
    }

    const World& world_;
    const PathTracer& tracer_;
    Lens lens_;
    glm::dvec3 eye_;
    std::uint64_t seed_;
    std::uint32_t perHalf_;
    ReferenceImage result_;
    std::atomic<std::uint64_t> nonFinite_ = 0;
};

// Hands out tiles to threads until all are done or `progress` says no. Whether all are.
bool traceAll(Picture& picture, std::uint32_t threads,
              const std::function<bool(double)>& progress) {
    const std::size_t tiles = picture.tiles();
    std::atomic<std::size_t> next = 0, done = 0;
    std::atomic<bool> cancelled = false;
    std::mutex mutex;
    std::condition_variable changed;
    std::uint32_t working = threads;
    const auto work = [&] {
        for (std::size_t tile; !cancelled && (tile = next++) < tiles;) {
            if (picture.traceTile(tile, cancelled)) ++done;
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
    Lighting lighting{
        .environment = {request.environment, worldFromMap, intensity},
        .lamps = lampsOf(request.scene, pose, origin, request.environment, worldFromMap, intensity),
        .backgroundVisible = request.frame.environment.visible};
    if (request.mode == ReferenceMode::effects)
        lighting.environment.prepareDiffuse();
    else
        lighting.environment.prepareChoices();
    for (const auto& [name, map] : request.maps) {
        lighting.named.try_emplace(name, *map, glm::dmat3(1.0), intensity);
    }
    return lighting;
}

}  // namespace

std::optional<ReferenceImage> traceReference(const ReferenceRequest& request,
                                             const std::function<bool(double)>& progress) {
    check(request);
    if (progress && !progress(0.0)) return std::nullopt;
    const FrameRequest& frame = request.frame;
    const Pose pose = poseAt(request.scene, *clipsNamed(request.scene, frame.clip), frame.time);
    const View view = requestedView(frame.camera, request.scene, pose, frame.width, frame.height);
    const MaterialBindings materials = bindMaterials(request.scene, frame.overrides);

    const World world(request.scene, pose, materials, frame.effects);
    const Lighting lighting =
        lightingOf(request, pose, world.origin(), worldFromMap(frame, request.scene));
    const PathTracer tracer(world, lighting, frame.effects, request.mode);

    const std::uint32_t threads =
        request.threads > 0 ? request.threads : std::max(1u, std::thread::hardware_concurrency());
    Picture picture(world, tracer, view, request);
    if (!traceAll(picture, std::min(threads, kMaxReferenceThreads), progress)) {
        return std::nullopt;
    }
    return picture.finished();
}

}  // namespace clerestory
