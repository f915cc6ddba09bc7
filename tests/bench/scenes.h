// Scenes of a benchmark's command line, and views that move a little.
#pragma once

#include "renderer.h"
#include "scene/builtin/builtin_scenes.h"
#include "scene/import/in_process.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace clerestory::bench {

// From the same direction as a fitted view, with the bounding sphere in the frame: the view of the
// published figures, which do not change when default views do.
inline DefaultView sphereView(const Scene& scene) {
    const Bounds bounds = lastingBounds(scene, poseAt(scene, 0.0));
    DefaultView view{.target = glm::dvec3(bounds.center()), .yfov = 0.7};
    const double radius = std::max(1e-6, 0.5 * static_cast<double>(bounds.diagonal()));
    const double distance = radius / std::sin(0.5 * view.yfov);
    view.position = view.target + distance * glm::normalize(glm::dvec3(0.5, 0.35, 1.0));
    return view;
}

// A built-in's id or a file; `NAME@x,y,z:x,y,z` puts the eye at the first point, looking at the
// second.
inline Scene loadScene(const std::string& argument) {
    const std::size_t at = argument.rfind('@');
    const std::string name = argument.substr(0, at);
    std::optional<Scene> builtin = makeBuiltinScene(name);
    Scene scene = builtin ? std::move(*builtin) : importSceneInProcess(name);
    if (!builtin) scene.id = std::filesystem::path(name).stem().string();
    if (at != std::string::npos) {
        DefaultView view{.yfov = 1.0};
        if (std::sscanf(argument.c_str() + at, "@%lf,%lf,%lf:%lf,%lf,%lf", &view.position.x,
                        &view.position.y, &view.position.z, &view.target.x, &view.target.y,
                        &view.target.z) != 6) {
            throw std::runtime_error("a view is written @x,y,z:x,y,z, not " + argument.substr(at));
        }
        scene.defaultView = view;
    } else if (scene.defaultView && scene.defaultView->fit != glm::dvec2(0.0)) {
        scene.defaultView = sphereView(scene);
    }
    return scene;
}

// A view, turned about the vertical axis through the eye. Without shadows and light between
// surfaces, which change while they are computed.
inline FrameRequest turned(const std::string& scene, const DefaultView& view, double angle) {
    const glm::dvec3 d = view.target - view.position;
    const double c = std::cos(angle), s = std::sin(angle);
    FrameRequest request;
    request.scene = scene;
    request.camera.position = view.position;
    request.camera.target = view.position + glm::dvec3(c * d.x + s * d.z, d.y, c * d.z - s * d.x);
    request.camera.yfov = view.yfov;
    request.effects.shadows = request.effects.indirectLight = false;
    return request;
}

}  // namespace clerestory::bench
