// Frames of lenses: every pixel shows what its ray meets, mirrors and channels included; two ways
// to one picture; and no border between the views from which a frame is assembled.
#include "plan/lens/lens.h"
#include "measures/errors.h"
#include "plan/visibility/view.h"
#include "reference/reference.h"
#include "room.h"
#include "scene/builtin/builtin_scenes.h"

#include <cstdio>
#include <cstring>
#include <numbers>

namespace clerestory::test {
namespace {

class Lenses : public GlTest {};

constexpr double kPi = std::numbers::pi;

struct Case {
    const char* name;
    LensRequest lens;
    std::uint32_t width, height;
    std::optional<Intrinsics> intrinsics = {};
};

std::vector<Case> cases() {
    const Intrinsics wide{70, 75, 83, 58, PixelCenter::half};
    return {{"equirectangular", EquirectangularLens{}, 160, 80},
            {"strip", EquirectangularLens{2.0 * kPi, 0.9}, 200, 29},
            {"grid", CubeLens{}, 96, 64},
            {"cross", CubeLens{CubeLayout::cross}, 130, 97},
            {"fisheye 80", FisheyeLens{1.4}, 90, 90},
            {"fisheye 180", FisheyeLens{}, 121, 90},
            {"fisheye 270", FisheyeLens{1.5 * kPi}, 90, 90},
            {"OpenCV fisheye", FisheyeLens{.k1 = 0.03, .k2 = -0.01, .k3 = 0.002, .k4 = -0.0002},
             160, 120, wide},
            {"barrel", PerspectiveLens{-0.05, 0.002, 0.0, 0.002, -0.001}, 160, 120, wide},
            {"pincushion", PerspectiveLens{.k1 = 0.1}, 160, 120, wide}};
}

FrameRequest with(FrameRequest r, const Case& c) {
    r.camera.yfov.reset();
    r.camera.lens = c.lens;
    r.camera.intrinsics = c.intrinsics;
    r.width = c.width;
    r.height = c.height;
    return r;
}

// A pose that is not parallel to anything.
void turn(CameraRequest& camera, const glm::dvec3& eye = {0.4, -0.3, 0.7}) {
    camera = {};
    camera.position = eye;
    camera.target = eye + glm::dvec3(-0.5, 0.35, -0.8);
}

glm::dmat3 worldFromCamera(const CameraRequest& camera) {
    return glm::dmat3(worldFromLookAt(*camera.position, *camera.target, {0, 1, 0}));
}

// Where a ray from inside leaves the room.
double distanceToWall(const glm::dvec3& eye, const glm::dvec3& direction) {
    double nearest = INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        const double wall = direction[axis] > 0.0 ? kRoom : -kRoom;
        if (direction[axis] != 0.0)
            nearest = std::min(nearest, (wall - eye[axis]) / direction[axis]);
    }
    return nearest;
}

// act(x, y, ray): for each pixel with its ray in world space, or without one.
void forEachRay(const FrameRequest& r, auto&& act) {
    const Lens lens = lensFor(*r.camera.lens, r.camera.intrinsics, r.width, r.height);
    const glm::dmat3 world = worldFromCamera(r.camera);
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            auto ray = rayOf(lens, {x + 0.5, y + 0.5});
            if (ray) ray = world * *ray;
            act(x, y, ray);
        }
    }
}

FrameRequest roomRequest() {
    Scene scene;
    Room{}.build(scene);
    FrameRequest r = request(std::move(scene), "lensRoom");
    turn(r.camera);
    return r;
}

FrameRequest roomRequest(std::uint32_t width, std::uint32_t height) {
    FrameRequest r = roomRequest();
    r.camera.yfov = 1.1;
    r.width = width;
    r.height = height;
    return r;
}

FrameRequest channelOf(FrameRequest r, Channel channel) {
    r.output.channel = channel;
    r.output.format = OutputFormat::npy;
    return r;
}

}  // namespace

// ---- what each pixel shows -----------------------------------------------------------------

TEST_F(Lenses, EveryPixelShowsTheWallThatItsRayMeets) {
    const FrameRequest plain = roomRequest();
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const FrameRequest r = with(plain, c);
        const Image image = renderer().render(r).image;
        std::uint64_t compared = 0, black = 0;
        forEachRay(r, [&](std::uint32_t x, std::uint32_t y, const std::optional<glm::dvec3>& ray) {
            if (!ray) {
                ++black;
                EXPECT_EQ(color(image, x, y), glm::vec3(0.0f)) << x << " " << y;
                return;
            }
            const glm::dvec3 eye = *r.camera.position;
            double margin = 0.0;
            const glm::vec3 wall =
                Room{}.radianceAt(eye + *ray * distanceToWall(eye, *ray), margin);
            if (margin < 0.5) return;  // a pixel and a half of the smallest frames
            ++compared;
            EXPECT_LT(glm::length(color(image, x, y) - wall), 2e-3f) << x << " " << y;
        });
        EXPECT_GT(compared, std::uint64_t{c.width} * c.height / 8);
        EXPECT_EQ(black > 0,
                  c.name == std::string("fisheye 180") || c.name == std::string("cross") ||
                      c.name == std::string("fisheye 80") || c.name == std::string("fisheye 270"));
    }
}

TEST_F(Lenses, ChannelsAreThoseOfTheRays) {
    const FrameRequest plain = roomRequest();
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const FrameRequest r = with(plain, c);
        const Image depth = renderer().render(channelOf(r, Channel::depth)).image;
        const Image normal = renderer().render(channelOf(r, Channel::normal)).image;
        const Image id = renderer().render(channelOf(r, Channel::objectId)).image;
        const bool planar = std::holds_alternative<PerspectiveLens>(c.lens);
        const glm::dvec3 forward = -worldFromCamera(r.camera)[2];
        double worst = 0.0;
        std::uint64_t count = 0, wrong = 0;
        forEachRay(r, [&](std::uint32_t x, std::uint32_t y, const std::optional<glm::dvec3>& ray) {
            if (!ray) {
                EXPECT_EQ(number(depth, x, y), 0.0f);
                EXPECT_EQ(number(id, x, y), 0.0f);
                return;
            }
            const glm::dvec3 eye = *r.camera.position;
            const double distance = distanceToWall(eye, *ray);
            double margin = 0.0;
            Room{}.radianceAt(eye + *ray * distance, margin);
            if (margin < 0.35) return;
            const double expected = planar ? distance * glm::dot(forward, *ray) : distance;
            worst = std::max(worst, std::abs(number(depth, x, y) - expected) / expected);
            ++count;
            // Unlike colour, the nearest texel of one view: exactly its surface.
            const glm::dvec3 at = eye + *ray * distance;
            int axis = 0;
            for (int i = 1; i < 3; ++i) axis = std::abs(at[i]) > std::abs(at[axis]) ? i : axis;
            glm::vec3 inwards(0.0f);
            inwards[axis] = at[axis] > 0 ? -1.0f : 1.0f;
            wrong += std::abs(std::abs(color(normal, x, y)[axis]) - 1.0f) > 1e-5f;
            const int quad = 8 * axis + (at[axis] > 0) + 2 * (at[(axis + 1) % 3] > 0) +
                             4 * (at[(axis + 2) % 3] > 0);
            wrong += number(id, x, y) != float(quad + 1);
        });
        EXPECT_EQ(wrong, 0u);
        EXPECT_GT(count, 100u);
        // Half a texel of slope; pixels of the smallest frame are 4 degrees wide.
        EXPECT_LT(worst, 0.09);
        std::printf("%s: depth within %.2g over %llu pixels\n", c.name, worst,
                    static_cast<unsigned long long>(count));
    }
}

// ---- two ways to one picture ---------------------------------------------------------------

TEST_F(Lenses, DistortionWithoutCoefficientsGivesTheSameBytes) {
    FrameRequest r = roomRequest(131, 77);
    const Image plain = renderer().render(r).image;
    r.camera.lens = PerspectiveLens{};
    EXPECT_EQ(renderer().render(r).image.data, plain.data);
    r.camera.yfov.reset();
    r.camera.lens.reset();
    r.camera.orthographicHeight = 2.5;
    const Image parallel = renderer().render(r).image;
    r.camera.orthographicHeight.reset();
    r.camera.lens = OrthographicLens{2.5};
    EXPECT_EQ(renderer().render(r).image.data, parallel.data);
}

// Resampling costs no accuracy: against the mean of 16 samples of each pixel.
TEST_F(Lenses, TinyDistortionIsAsAccurateAsNone) {
    FrameRequest r = roomRequest(128, 96);
    const Image plain = renderer().render(r).image;
    FrameRequest fine = r;
    fine.width *= 4;
    fine.height *= 4;
    const Image large = renderer().render(fine).image;
    Image truth = makeImage(128, 96, 3, PixelType::float32);
    for (std::uint32_t y = 0; y < large.height; ++y) {
        for (std::uint32_t x = 0; x < large.width; ++x) {
            const glm::vec3 c = color(large, x, y) / 16.0f;
            float* to = truth.floats() + 3 * (128 * (y / 4) + x / 4);
            for (int i = 0; i < 3; ++i) to[i] += c[i];
        }
    }
    r.camera.lens = PerspectiveLens{.k1 = 1e-12};
    const LinearErrors without = linearErrors(plain, truth);
    const LinearErrors with = linearErrors(renderer().render(r).image, truth);
    std::printf("relMSE %.4f without, %.4f with distortion\n", without.relMse, with.relMse);
    EXPECT_LT(with.relMse, 1.1 * without.relMse);
    EXPECT_LT(std::abs(with.bias), 2e-3 * with.meanReference);
}

// The faces of a cube are the frames of six cameras, texel by texel.
TEST_F(Lenses, TheFacesOfACubeAreFramesOfSixCameras) {
    FrameRequest r = roomRequest();
    r.camera.cameraToWorld.reset();
    r.width = 96;
    r.height = 64;
    r.camera.lens = CubeLens{};
    for (const Channel channel : {Channel::color, Channel::objectId, Channel::normal}) {
        r.output.channel = channel;
        r.output.format = OutputFormat::npy;
        const Image cube = renderer().render(r).image;
        for (int face = 0; face < 6; ++face) {
            FrameRequest one = r;
            one.width = one.height = 32;
            one.camera.lens.reset();
            one.camera.target.reset();
            one.camera.intrinsics = Intrinsics{16, 16, 16, 16, PixelCenter::half};
            const glm::dmat3 world =
                worldFromCamera(r.camera) * cubeFaceAxes()[static_cast<std::size_t>(face)];
            const glm::dquat q = glm::quat_cast(world);
            one.camera.orientation = {q.x, q.y, q.z, q.w};
            const Image frame = renderer().render(one).image;
            std::uint64_t different = 0;
            for (std::uint32_t y = 0; y < 32; ++y) {
                for (std::uint32_t x = 0; x < 32; ++x) {
                    for (std::uint32_t i = 0; i < frame.channels; ++i) {
                        const std::uint32_t cx = x + 32 * (face % 3), cy = y + 32 * (face / 3);
                        const float a = cube.floats()[(cy * 96 + cx) * cube.channels + i];
                        const float b = frame.floats()[(y * 32 + x) * frame.channels + i];
                        different += std::abs(a - b) > 2e-3f * std::max(1.0f, std::abs(b));
                    }
                }
            }
            // Where colours of two views are mixed, 3 pixels from the border at most, their
            // samples may lie on different sides of an edge.
            EXPECT_LE(different, channel == Channel::color ? 60u : 6u) << face;
        }
    }
}

TEST_F(Lenses, APanoramaShowsAlongXWhatACameraShowsThatLooksThere) {
    FrameRequest r = roomRequest();
    r.camera.target = *r.camera.position + glm::dvec3(0, 0, -1);
    r.camera.lens = EquirectangularLens{};
    r.width = 401;
    r.height = 201;
    const Image panorama = renderer().render(r).image;
    FrameRequest one = r;
    one.camera.lens.reset();
    one.camera.yfov = 0.5;
    one.camera.target = *r.camera.position + glm::dvec3(1, 0, 0);
    one.width = one.height = 65;
    const glm::vec3 expected = centerColor(renderer().render(one).image);
    EXPECT_LT(glm::length(color(panorama, 300, 100) - expected), 2e-3f);
}

// A fisheye's picture resampled here as a camera of 60 degrees shows it.
TEST_F(Lenses, AFisheyeContainsThePerspectivePicture) {
    FrameRequest r = roomRequest();
    r.camera.lens = FisheyeLens{};
    r.width = r.height = 480;
    const Image fisheye = renderer().render(r).image;
    const Lens lens = lensFor(*r.camera.lens, {}, 480, 480);
    FrameRequest one = r;
    one.camera.lens.reset();
    one.camera.yfov = 1.0;
    one.width = one.height = 96;
    const Image frame = renderer().render(one).image;
    Image resampled = makeImage(96, 96, 3, PixelType::float32);
    const double focal = 48.0 / std::tan(0.5);
    for (std::uint32_t y = 0; y < 96; ++y) {
        for (std::uint32_t x = 0; x < 96; ++x) {
            const glm::dvec2 at =
                *pixelOf(lens, glm::dvec3((x + 0.5 - 48.0) / focal, (47.5 - y) / focal, -1.0));
            const glm::vec3 c =
                color(fisheye, static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y));
            std::memcpy(resampled.floats() + 3 * (96 * y + x), &c, sizeof c);
        }
    }
    EXPECT_LT(linearErrors(resampled, frame).relMse, 0.02);
}

// ---- mirrors and glass ---------------------------------------------------------------------

// A mirror in the plane z = -1 of the room: arithmetic says what every pixel shows in it.
TEST_F(Lenses, MirrorsShowWhatTheReflectedRayMeets) {
    for (const PlanarMethod method : {PlanarMethod::mirror, PlanarMethod::traced}) {
        Scene scene;
        Room{}.build(scene);
        place(scene, quad(1.2f, addMaterial(scene, mirrorMetal())), moved(0, 0, -1.0));
        FrameRequest plain = request(std::move(scene), "lensMirror");
        turn(plain.camera);
        plain.accuracy.planar = method;
        for (const Case& c : cases()) {
            SCOPED_TRACE(c.name);
            const FrameRequest r = with(plain, c);
            const Image image = renderer().render(r).image;
            const Image through = renderer().render(channelOf(r, Channel::through)).image;
            std::uint64_t compared = 0;
            const glm::dvec3 eye = *r.camera.position;
            forEachRay(
                r, [&](std::uint32_t x, std::uint32_t y, const std::optional<glm::dvec3>& ray) {
                    if (!ray || !(ray->z < 0.0)) return;
                    const glm::dvec3 at = eye + *ray * ((-1.0 - eye.z) / ray->z);
                    const double inside = 1.2 - std::max(std::abs(at.x), std::abs(at.y));
                    if (std::abs(inside) < 0.35) return;
                    const float label = number(through, x, y);
                    if (inside < 0.0) {
                        EXPECT_EQ(label, 1.0f) << x << " " << y;
                        return;
                    }
                    EXPECT_TRUE(method == PlanarMethod::mirror ? label >= 16.0f : label == 3.0f)
                        << label;
                    const glm::dvec3 reflected(ray->x, ray->y, -ray->z);
                    double margin = 0.0;
                    const glm::vec3 wall =
                        Room{}.radianceAt(at + reflected * distanceToWall(at, reflected), margin);
                    if (margin < 0.5) return;
                    ++compared;
                    EXPECT_LT(glm::length(color(image, x, y) - wall), 5e-3f) << x << " " << y;
                });
            EXPECT_GT(compared, 20u);
        }
    }
}

// A pane of index 1 without tint is invisible through every lens, whatever its technique.
TEST_F(Lenses, GlassOfIndexOneIsInvisible) {
    for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
        Scene with1;
        Room{}.build(with1);
        place(with1, quad(1.2f, addMaterial(with1, clearGlass(1.0f))), moved(0, 0, -1.0));
        FrameRequest glass = request(std::move(with1), "lensGlass");
        turn(glass.camera);
        glass.accuracy.glass = method;
        const FrameRequest bare = roomRequest();
        for (const Case& c : cases()) {
            SCOPED_TRACE(c.name);
            const Image a = renderer().render(with(glass, c)).image;
            const Image b = renderer().render(with(bare, c)).image;
            EXPECT_LT(linearErrors(a, b).relMse, 2e-5);
        }
    }
}

// ---- borders between views -----------------------------------------------------------------

namespace {

FrameRequest builtin(const char* name) {
    renderer().addScene(*makeBuiltinScene(name));
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.scene = name;
    r.output.format = OutputFormat::npy;
    return r;
}

float luminance(const Image& image, std::uint32_t x, std::uint32_t y) {
    return glm::dot(color(image, x, y), glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

}  // namespace

// Two frames of the same rays: a quarter of a panorama, in which the border between the front and
// the right view is in the middle, and a frame that looks there with one view.
TEST_F(Lenses, BordersBetweenViewsAreInvisible) {
    FrameRequest r = builtin("chapel");
    r.camera.position = {0.5, 1.75, 7.0};
    r.camera.target = *r.camera.position + glm::dvec3(0.0, 0.0, -1.0);
    r.camera.lens = EquirectangularLens{};
    r.width = 1280;
    r.height = 640;
    const Image panorama = renderer().render(r).image;
    FrameRequest one = r;
    one.camera.target = *r.camera.position + glm::dvec3(1.0, 0.0, -1.0);
    one.camera.lens = EquirectangularLens{0.5 * kPi, 0.5 * kPi};
    one.width = one.height = 320;
    const Frame single = renderer().render(one);
    ASSERT_EQ(
        std::get<AssembleLens>(std::find_if(single.plan.passes.begin(), single.plan.passes.end(),
                                            [](const Pass& p) { return p.kind() == "lens"; })
                                   ->work)
            .tiles.size(),
        1u);
    // Mean differences of columns: at the border and elsewhere.
    double border = 0.0, elsewhere = 0.0;
    for (std::uint32_t x = 20; x < 300; ++x) {
        double sum = 0.0;
        for (std::uint32_t y = 20; y < 300; ++y) {
            const float a = luminance(panorama, 640 + x, 160 + y);
            const float b = luminance(single.image, x, y);
            sum += std::abs(a - b) / (b + 0.01);
        }
        if (x >= 154 && x < 166)
            border += sum / (12 * 280);
        else
            elsewhere += sum / (268 * 280);
    }
    std::printf("mean difference %.4f at the border, %.4f elsewhere\n", border, elsewhere);
    EXPECT_LT(border, 1.5 * elsewhere + 0.005);
    EXPECT_LT(elsewhere, 0.05);
}

// ---- the reference -------------------------------------------------------------------------

// The path tracer's rays are the lens's inverse. Errors at standard; those of a perspective camera
// at the same place for comparison.
TEST_F(Lenses, FramesAreCloseToTheReference) {
    for (const char* name : {"chapel", "teapots", "six-walls"}) {
        const Scene scene = *makeBuiltinScene(name);
        const EnvironmentMap map = *builtinEnvironment(scene.environment);
        const FrameRequest r = builtin(name);
        const std::vector<Case> all = {
            {"perspective", PerspectiveLens{}, 96, 64},
            {"cube", CubeLens{}, 96, 64},
            {"barrel", PerspectiveLens{-0.2, 0.05, 0.0, 0.001, 0.001}, 96, 64},
            {"fisheye 180", FisheyeLens{}, 80, 80},
            {"equirectangular", EquirectangularLens{}, 128, 64}};
        LinearErrors perspective, cube;
        for (const Case& c : all) {
            const FrameRequest frame = with(r, c);
            const auto reference =
                traceReference({.scene = scene, .frame = frame, .environment = map, .samples = 64});
            ASSERT_TRUE(reference.has_value());
            EXPECT_EQ(reference->nonFinite, 0u);
            const LinearErrors errors =
                linearErrors(renderer().render(frame).image, reference->color);
            if (c.name == std::string("perspective")) perspective = errors;
            if (c.name == std::string("cube")) cube = errors;
            std::printf("%s, %s: relMSE %.4f, RMSE / mean %.4f\n", name, c.name, errors.relMse,
                        errors.rmse / errors.meanReference);
            if (name != std::string("six-walls")) {
                EXPECT_LE(errors.relMse, perspective.relMse) << name << " " << c.name;
                continue;
            }
            // A channel is 0 next to one of 1 there, and relMSE divides what a look-up between two
            // texels takes from the neighbour by 0.01 of the mean. The faces of the cube are six
            // perspective frames, without such look-ups.
            if (cube.pixels > 0) {
                EXPECT_LE(errors.rmse / errors.meanReference, cube.rmse / cube.meanReference)
                    << c.name;
            }
        }
    }
}

}  // namespace clerestory::test
