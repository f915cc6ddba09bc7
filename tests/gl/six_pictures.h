// Images of six cameras of 90 degrees around a point, to compare captured cubes with.
#pragma once

#include "sight.h"

#include <vector>

namespace clerestory::test {

class SixPictures {
public:
    // Renders `camera` once along each axis. Its pictures are square.
    SixPictures(FrameRequest camera, const glm::dvec3& center) {
        camera.camera.yfov = glm::half_pi<double>();
        camera.camera.position = center;
        for (int i = 0; i < 6; ++i) {
            glm::dvec3 towards(0.0);
            towards[i / 2] = i % 2 ? -1.0 : 1.0;
            camera.camera.target = center + towards;
            camera.camera.up = i / 2 == 1 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
            cameras_.push_back(camera);
            pictures_.push_back(renderer().render(camera).image);
        }
    }

    // The pixel of the picture that the direction lies in; none where its neighbours differ.
    std::optional<glm::vec3> along(const glm::dvec3& d) const {
        const glm::dvec3 a = glm::abs(d);
        const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
        const std::size_t face = 2 * axis + (d[axis] < 0.0);
        const FrameRequest& c = cameras_[face];
        const Image& picture = pictures_[face];
        const glm::dmat3 worldFromView(
            worldFromLookAt(*c.camera.position, *c.camera.target, *c.camera.up));
        const glm::dvec3 v = glm::transpose(worldFromView) * d;
        const int size = int(c.width);
        const int x = int((0.5 - 0.5 * v.x / v.z) * size), y = int((0.5 + 0.5 * v.y / v.z) * size);
        if (x < 1 || y < 1 || x > size - 2 || y > size - 2) return std::nullopt;
        const glm::vec3 middle = color(picture, x, y);
        for (int i = 0; i < 9; ++i) {
            const glm::vec3 other = color(picture, x + i % 3 - 1, y + i / 3 - 1);
            if (greatestDifference(middle, other) > 0.01) return std::nullopt;
        }
        return middle;
    }

private:
    std::vector<FrameRequest> cameras_;
    std::vector<Image> pictures_;
};

}  // namespace clerestory::test
