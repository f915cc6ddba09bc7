// With the camera looking along -Z, w = -Z, and the x coordinate of a pixel is fx X / w + cx.
#include "plan/visibility/view.h"

#include "scene/default_view.h"
#include "scene/fit.h"
#include "scene/spelling.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

glm::dmat4 rigid(const glm::dmat3& rotation, const glm::dvec3& translation) {
    glm::dmat4 m(rotation);
    m[3] = glm::dvec4(translation, 1.0);
    return m;
}

// The rotation as a quaternion with w >= 0, rounded to a grid of 2^-30 (a billionth of a radian, a
// millionth of a pixel), so that all forms of a rotation give the same bits.
glm::dmat3 canonicalRotation(const glm::dmat3& rotation) {
    glm::dquat q = glm::normalize(glm::quat_cast(rotation));
    const double sign = q.w < 0.0 ? -1.0 : 1.0;
    const double grid = 1073741824.0;
    const auto snapped = [&](double v) { return std::round(sign * v * grid) / grid + 0.0; };
    q = glm::dquat(snapped(q.w), snapped(q.x), snapped(q.y), snapped(q.z));
    return glm::mat3_cast(glm::normalize(q));
}

// Gram-Schmidt: removes a client's rounding from a rotation.
glm::dmat3 orthonormal(const glm::dmat3& m) {
    const glm::dvec3 z = glm::normalize(m[2]);
    const glm::dvec3 y = glm::normalize(m[1] - glm::dot(m[1], z) * z);
    return {glm::cross(y, z), y, z};
}

struct PlacedCamera {
    glm::dmat4 worldFromCamera{1.0};
    double yfov = kDefaultYfov;
    std::optional<double> orthographicHalfHeight;
    std::optional<double> znear, zfar;
};

PlacedCamera sceneCamera(const std::string& name, const Scene& scene, const Pose& pose) {
    std::string names;
    for (const Camera& c : camerasOf(scene, pose)) {
        if (c.name == name) {
            PlacedCamera placed;
            const glm::dmat4& m = pose.worldFromNode[c.node];
            // The scale of a camera node does not affect the view (glTF 2.0, section 3.10).
            placed.worldFromCamera = rigid(orthonormal(glm::dmat3(m)), glm::dvec3(m[3]));
            placed.yfov = c.yfov;
            if (c.orthographic) placed.orthographicHalfHeight = c.yHalfHeight;
            if (c.znear > 0.0) placed.znear = c.znear;
            if (c.zfar > 0.0) placed.zfar = c.zfar;
            return placed;
        }
        names += (names.empty() ? "" : ", ") + c.name;
    }
    throw InvalidRequest({{"/camera/name", "the scene has no camera of this name",
                           names.empty() ? "none: the scene has no cameras" : "one of: " + names}});
}

// Which instances a name of a node, or of a material, or both choose; without names all but a ground.
std::vector<bool> chosenBy(const FitRequest& fit, const Scene& scene) {
    std::vector<bool> nodes;
    if (fit.node) nodes = nodesAtOrBelow(scene, *fit.node);
    const bool everything = !fit.node && !fit.material;
    std::vector<bool> chosen;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const std::string& material = scene.materials[instance.material].name;
        chosen.push_back((!fit.node || nodes[instance.node]) &&
                         (!fit.material || material == *fit.material) &&
                         (!everything || i != scene.ground || scene.instances.size() == 1));
    }
    if (std::find(chosen.begin(), chosen.end(), true) != chosen.end()) return chosen;
    const auto names = fit.node ? namesOf(scene.nodes) : namesOf(scene.materials);
    const std::string wanted = fit.node ? *fit.node : fit.material.value_or("");
    throw InvalidRequest(
        {{fit.node ? "/camera/fit/node" : "/camera/fit/material",
          "chooses no surface" + didYouMean(wanted, names),
          names.empty() ? "no names in this scene" : listedNearest(wanted, names)}});
}

// The part of the frame within the margins. lens: clipFromView, whose sides give the frame.
FrameTangents innerFrame(const glm::dmat4& lens, double inner) {
    return {.left = (inner - lens[2][0]) / lens[0][0],
            .right = (inner + lens[2][0]) / lens[0][0],
            .bottom = (inner - lens[2][1]) / lens[1][1],
            .top = (inner + lens[2][1]) / lens[1][1]};
}

// The same of a distorted perspective lens: the greatest rectangle of tangents inside.
FrameTangents innerFrame(const Lens& lens, double inner) {
    const glm::dvec2 middle = 0.5 * glm::dvec2(lens.width, lens.height);
    FrameTangents frame{INFINITY, INFINITY, INFINITY, INFINITY};
    const auto tangentsAt = [&](double x, double y) {
        const glm::dvec3 ray = *rayOf(lens, middle + inner * middle * glm::dvec2(x, y));
        return glm::dvec2(ray.x, ray.y) / -ray.z;
    };
    constexpr int kPoints = 32;  // per side
    for (int i = 0; i <= kPoints; ++i) {
        const double along = 2.0 * i / kPoints - 1.0;
        frame.left = std::min(frame.left, -tangentsAt(-1.0, along).x);
        frame.right = std::min(frame.right, tangentsAt(1.0, along).x);
        frame.top = std::min(frame.top, tangentsAt(along, -1.0).y);
        frame.bottom = std::min(frame.bottom, -tangentsAt(along, 1.0).y);
    }
    return frame;
}

glm::dmat4 fittedCamera(const FitRequest& fit, const Scene& scene, const Pose& pose,
                        const FrameTangents& frame) {
    const ViewAxes axes = uprightAxes(directionTo(fit.azimuth, fit.elevation));
    auto corners = cornersOf(scene, pose, chosenBy(fit, scene));
    if (fit.allAround) corners = turnedCorners(corners, axes);
    return rigid({axes.right, axes.up, axes.back}, fittedEye(corners, axes, frame));
}

Intrinsics intrinsicsOf(double yfov, std::uint32_t width, std::uint32_t height) {
    const double focal = 0.5 * height / std::tan(0.5 * yfov);
    return {focal, focal, 0.5 * width, 0.5 * height, PixelCenter::half};
}

PlacedCamera placedCamera(const CameraRequest& c, const Scene& scene, const Pose& pose,
                          std::uint32_t width, std::uint32_t height) {
    const double aspect = static_cast<double>(width) / height;
    if (c.name) return sceneCamera(*c.name, scene, pose);
    if (c.fit) {
        const double yfov = c.yfov.value_or(kFitYfov);
        const double inner = 1.0 - 2.0 * c.fit->margin;
        if (c.lens && needsLens(*c.lens)) {
            const Lens lens = lensFor(
                *c.lens, c.intrinsics.value_or(intrinsicsOf(yfov, width, height)), width, height);
            return {.worldFromCamera = fittedCamera(*c.fit, scene, pose, innerFrame(lens, inner)),
                    .yfov = yfov};
        }
        const glm::dmat4 lens = c.intrinsics ? perspective(*c.intrinsics, width, height, 1.0, {})
                                             : perspective(yfov, aspect, 1.0, {});
        return {.worldFromCamera = fittedCamera(*c.fit, scene, pose, innerFrame(lens, inner)),
                .yfov = yfov};
    }
    PlacedCamera placed;
    if (const auto own = worldFromPose(c)) {
        placed.worldFromCamera = *own;
    } else {
        const DefaultView view = defaultView(scene);
        placed.worldFromCamera =
            worldFromLookAt(view.position, view.target, glm::dvec3(0.0, 1.0, 0.0));
        placed.yfov = fieldOfView(view, aspect);
    }
    return placed;
}

// The near plane may be close: reversed depth resolves 1e-7 of the distance for any near plane.
constexpr double kNearPerDiagonal = 1e-4;

}  // namespace

glm::dmat4 worldFromLookAt(const glm::dvec3& position, const glm::dvec3& target,
                           const glm::dvec3& up) {
    const glm::dvec3 back = glm::normalize(position - target);
    // Sine of the angle to the line of sight below which `up` is ignored.
    constexpr double kParallel = 1e-9;
    glm::dvec3 right(0.0);
    for (const glm::dvec3& candidate :
         {glm::normalize(up), glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0)}) {
        right = glm::cross(candidate, back);
        if (glm::length(right) > kParallel) break;
    }
    right = glm::normalize(right);
    return rigid({right, glm::cross(back, right), back}, position);
}

std::optional<glm::dmat4> worldFromPose(const CameraRequest& c) {
    if (c.cameraToWorld) {
        const std::array<double, 16>& m = *c.cameraToWorld;
        glm::dmat3 rotation(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
        if (c.convention == Convention::opencv) {
            rotation[1] = -rotation[1];
            rotation[2] = -rotation[2];
        }
        return rigid(orthonormal(rotation), {m[12], m[13], m[14]});
    }
    if (!c.position) return std::nullopt;
    if (c.orientation) {
        const auto& [x, y, z, w] = *c.orientation;
        return rigid(glm::mat3_cast(glm::normalize(glm::dquat(w, x, y, z))), *c.position);
    }
    return worldFromLookAt(*c.position, *c.target, c.up.value_or(glm::dvec3(0.0, 1.0, 0.0)));
}

Intrinsics lensOf(const glm::dmat4& clipFromView, std::uint32_t width, std::uint32_t height) {
    const glm::dmat4& m = clipFromView;
    return {.fx = 0.5 * m[0][0] * width,
            .fy = 0.5 * m[1][1] * height,
            .cx = 0.5 * (1.0 - m[2][0]) * width,
            .cy = 0.5 * (1.0 + m[2][1]) * height,
            .pixelCenter = PixelCenter::half};
}

namespace {

// Reversed: 1 at znear, 0 at zfar or at infinity.
void setDepth(glm::dmat4& clipFromView, double znear, std::optional<double> zfar) {
    clipFromView[2][2] = zfar ? znear / (*zfar - znear) : 0.0;
    clipFromView[3][2] = zfar ? znear * *zfar / (*zfar - znear) : znear;
}

}  // namespace

glm::dmat4 perspective(const Intrinsics& lens, std::uint32_t width, std::uint32_t height,
                       double znear, std::optional<double> zfar) {
    const double shift = lens.pixelCenter == PixelCenter::integer ? 0.5 : 0.0;
    glm::dmat4 m(0.0);
    m[0][0] = 2.0 * lens.fx / width;
    m[1][1] = 2.0 * lens.fy / height;
    m[2][0] = 1.0 - 2.0 * (lens.cx + shift) / width;
    m[2][1] = 2.0 * (lens.cy + shift) / height - 1.0;
    m[2][3] = -1.0;
    setDepth(m, znear, zfar);
    return m;
}

View withFar(const View& view, double zfar) {
    View result = view;
    setDepth(result.clipFromView, view.znear, zfar);
    return result;
}

glm::dmat4 perspective(double yfov, double aspect, double znear, std::optional<double> zfar) {
    // Intrinsics of a centred picture of 2 x 2 units.
    const double f = 1.0 / std::tan(0.5 * yfov);
    return perspective(Intrinsics{f / aspect, f, 1.0, 1.0, PixelCenter::half}, 2, 2, znear, zfar);
}

glm::dmat4 orthographic(double halfWidth, double halfHeight, double znear, double zfar) {
    glm::dmat4 m(1.0);
    m[0][0] = 1.0 / halfWidth;
    m[1][1] = 1.0 / halfHeight;
    m[2][2] = 1.0 / (zfar - znear);
    m[3][2] = zfar / (zfar - znear);
    return m;
}

namespace {

// None: perspective. The lens of the request replaces that of the scene's camera.
std::optional<double> orthographicHalfHeight(const CameraRequest& camera,
                                             const PlacedCamera& placed) {
    if (camera.orthographicHeight) return 0.5 * *camera.orthographicHeight;
    if (camera.lens) {
        const auto* orthographic = std::get_if<OrthographicLens>(&*camera.lens);
        return orthographic ? std::optional(0.5 * orthographic->height) : std::nullopt;
    }
    return camera.yfov || camera.intrinsics ? std::nullopt : placed.orthographicHalfHeight;
}

}  // namespace

std::optional<Lens> requestedLens(const CameraRequest& camera, const Scene& scene, const Pose& pose,
                                  std::uint32_t width, std::uint32_t height) {
    if (!camera.lens || !needsLens(*camera.lens)) return std::nullopt;
    std::optional<Intrinsics> intrinsics = camera.intrinsics;
    if (!intrinsics && std::holds_alternative<PerspectiveLens>(*camera.lens)) {
        const double yfov = camera.yfov  ? *camera.yfov
                            : camera.fit ? kFitYfov
                                         : placedCamera(camera, scene, pose, width, height).yfov;
        intrinsics = intrinsicsOf(yfov, width, height);
    }
    return lensFor(*camera.lens, intrinsics, width, height);
}

View requestedView(const CameraRequest& camera, const Scene& scene, const Pose& pose,
                   std::uint32_t width, std::uint32_t height) {
    const double aspect = static_cast<double>(width) / height;
    const PlacedCamera placed = placedCamera(camera, scene, pose, width, height);
    const Bounds bounds = lastingBounds(scene, pose);
    const double diagonal =
        bounds.empty() ? 1.0 : std::max(1e-6, static_cast<double>(bounds.diagonal()));

    View view;
    view.eye = glm::dvec3(placed.worldFromCamera[3]);
    const glm::dmat3 worldFromCamera = canonicalRotation(glm::dmat3(placed.worldFromCamera));
    const glm::dmat3 cameraFromWorld = glm::transpose(worldFromCamera);
    view.viewFromWorld = rigid(cameraFromWorld, -(cameraFromWorld * view.eye));

    std::optional<double> zfar = camera.zfar ? camera.zfar : placed.zfar;
    view.znear = camera.znear.value_or(placed.znear.value_or(kNearPerDiagonal * diagonal));
    if (zfar && !(*zfar > view.znear)) {
        if (camera.zfar && !camera.znear)
            view.znear = 1e-3 * *zfar;
        else
            zfar.reset();
    }

    const auto halfHeight = orthographicHalfHeight(camera, placed);
    if (halfHeight) {
        view.orthographic = true;
        if (!camera.znear && !placed.znear) view.znear = 0.0;
        if (!zfar) {
            const Bounds all = scene.ground == kNone ? bounds : worldBounds(scene, pose);
            const double reach = all.empty()
                                     ? 1.0
                                     : glm::length(glm::dvec3(all.center()) - view.eye) +
                                           std::max(1e-6, static_cast<double>(all.diagonal()));
            zfar = view.znear + reach;
        }
        const double half = std::max(1e-9, *halfHeight);
        view.clipFromView = orthographic(half * aspect, half, view.znear, *zfar);
    } else if (camera.intrinsics) {
        view.clipFromView = perspective(*camera.intrinsics, width, height, view.znear, zfar);
    } else {
        view.clipFromView =
            perspective(camera.yfov.value_or(placed.yfov), aspect, view.znear, zfar);
    }
    return view;
}

}  // namespace clerestory
