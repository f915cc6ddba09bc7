// What an open door shows: a terrace, a low wall, and cypresses against the evening sky.
#include "scene/builtin/chapel_parts.h"

#include <cmath>

namespace clerestory::chapel_parts {

void addOutside(Scene& scene, const Materials& m) {
    using namespace shapes;
    constexpr float kNear = kAisle, kFar = kAisle + 8.0f;

    MeshDraft terrace = draft("terrace", m.paving);
    addPatch(terrace, {kNear, 0.0f, kDoorZ + 16.0f}, {kFar - kNear, 0, 0}, {0, 0, -48.0f}, 8, 16);
    // The chapel's own wall keeps half of the sky from what lies at its foot.
    shadeFrom(terrace, 0, [](const Vertex& v) {
        return 1.0f - 0.55f * std::exp(-(v.position.x - kNear) / 2.5f);
    });
    addBox(terrace, {kFar - 0.4f, 0.0f, kDoorZ - 32.0f}, {kFar, 0.7f, kDoorZ + 16.0f});
    place(scene, std::move(terrace));

    MeshDraft trees = draft("cypresses", m.leaves);
    struct Tree {
        float x, z, height;
    };
    // Two of them stand where the nave's camera looks through the door.
    const Tree row[] = {{1.5f, -12.4f, 4.9f}, {2.0f, -15.2f, 6.2f}, {1.5f, -19.0f, 6.0f},
                        {2.2f, -7.5f, 6.6f},  {1.5f, -2.5f, 5.4f},  {2.0f, 3.0f, 6.4f}};
    for (const Tree& tree : row) {
        std::vector<glm::vec2> profile;
        constexpr int kSteps = 14;
        for (int i = 0; i <= kSteps; ++i) {
            const float t = static_cast<float>(i) / kSteps;
            // A flame's outline, ruffled.
            const float width = 0.9f * std::pow(t, 0.4f) * std::pow(1.0f - t, 0.75f) *
                                (1.0f + 0.10f * std::sin(19.0f * t + tree.z));
            profile.emplace_back(width, 0.05f + tree.height * t);
        }
        addLathe(trees, {kFar + tree.x, 0.0f, kDoorZ + tree.z}, profile, 10);
    }
    place(scene, std::move(trees));
}

}  // namespace clerestory::chapel_parts
