#include "layer_support.h"

namespace clerestory::test {

Image layer(FrameRequest r, Channel channel, OutputLayer which) {
    r.output.channel = channel;
    r.output.layer = which;
    return renderer().render(r).image;
}

glm::dmat4 facingBack(double x, double y, double z) {
    glm::dmat4 turned = moved(x, y, z);
    turned[0] = {-1, 0, 0, 0};
    turned[2] = {0, 0, -1, 0};
    return turned;
}

FrameRequest mirrorAndSquare() {
    Scene scene;
    const Index mirror = addMaterial(scene, mirrorMetal());
    Material red;
    red.baseColor = {0.5f, 0.25f, 0.125f, 1.0f};
    place(scene, quad(1.5f, mirror));
    place(scene, quad(1.0f, addMaterial(scene, red)), facingBack(0.25, 0.5, 3.0));
    return request(std::move(scene), "mirror and square");
}

FrameRequest glassBefore(bool solid) {
    Scene scene;
    Material glass = clearGlass();
    if (solid) glass.thickness = 1.0f;
    const Index material = addMaterial(scene, glass);
    if (solid) {
        MeshDraft block;
        block.name = "block";
        block.material = material;
        block.hasNormals = true;
        for (const double side : {1.0, -1.0}) {  // z = 0.5 and z = -0.5
            const auto first = static_cast<std::uint32_t>(block.vertices.size());
            for (const glm::vec2 corner :
                 {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
                Vertex v;
                v.position = glm::vec3(1.5f * corner, 0.5 * side);
                v.normal = glm::vec3(0, 0, side);
                block.vertices.push_back(v);
            }
            for (const std::uint32_t i :
                 side > 0 ? std::array{0u, 1u, 2u, 0u, 2u, 3u} : std::array{0u, 2u, 1u, 0u, 3u, 2u})
                block.indices.push_back(first + i);
        }
        place(scene, std::move(block));
    } else {
        place(scene, quad(1.5f, material));
    }
    place(scene, quad(2.0f, addMaterial(scene, {})), moved(0, 0, -2));
    return request(std::move(scene), solid ? "block" : "pane");
}

}  // namespace clerestory::test
