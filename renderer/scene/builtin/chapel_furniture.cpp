// Furniture of the chapel: braziers, a brass bird, a glass ball, pews, the altar, chandeliers.
#include "scene/builtin/chapel_parts.h"
#include "scene/builtin/modelling.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cmath>

namespace clerestory::chapel_parts {
namespace {

using namespace shapes;
using Path = std::vector<glm::vec3>;
using Profile = std::vector<glm::vec2>;

glm::dmat4 at(const glm::dvec3& position, double turn = 0.0, double size = 1.0) {
    return glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), position), turn, {0, 1, 0}),
                      glm::dvec3(size));
}

void addBraziers(Scene& scene, const Materials& m) {
    MeshDraft iron = draft("brazier", m.iron), embers = draft("embers", m.ember);
    const Profile bowl = {{0.0f, 0.92f},  {0.10f, 0.92f}, {0.26f, 0.98f}, {0.37f, 1.10f},
                          {0.40f, 1.22f}, {0.43f, 1.24f}, {0.43f, 1.26f}, {0.38f, 1.26f},
                          {0.35f, 1.12f}, {0.24f, 1.02f}, {0.0f, 1.00f}};
    for (const float z : {7.0f, -7.0f}) {
        for (const float x : {-2.55f, 2.55f}) {
            const glm::vec3 foot(x, 0.0f, z);
            addLathe(iron, foot, bowl, 40);
            for (int leg = 0; leg < 3; ++leg) {
                const float a = glm::two_pi<float>() * static_cast<float>(leg) / 3.0f + 0.4f;
                const glm::vec3 out(std::cos(a), 0.0f, std::sin(a));
                const Path path = {foot + 0.42f * out, foot + 0.30f * out + glm::vec3(0, 0.25f, 0),
                                   foot + 0.16f * out + glm::vec3(0, 0.6f, 0),
                                   foot + 0.22f * out + glm::vec3(0, 0.97f, 0)};
                addTube(
                    iron, smooth(path, 6), [](float) { return 0.026f; }, 8);
            }
            for (std::uint32_t i = 0; i < 46; ++i) {
                const auto random = [&](std::uint32_t k) {
                    return textures::hash(i, k, static_cast<std::uint32_t>(1000 + 7 * x + z));
                };
                const float r = 0.31f * std::sqrt(random(1)), a = glm::two_pi<float>() * random(2);
                const std::size_t first = embers.vertices.size();
                addSphere(embers, {}, 0.045f + 0.035f * random(3), 8);
                const glm::vec3 position =
                    foot + glm::vec3(r * std::cos(a),
                                     1.10f + 0.16f * (1.0f - r / 0.31f) + 0.05f * random(4),
                                     r * std::sin(a));
                glm::mat4 lump = glm::rotate(glm::translate(glm::mat4(1.0f), position),
                                             6.0f * random(5), glm::vec3(0.6f, 0.8f, 0.0f));
                lump = glm::scale(lump, glm::vec3(1.0f, 0.6f + 0.3f * random(6), 0.8f));
                transformFrom(embers, first, lump);
            }
        }
    }
    addToScene(scene, std::move(iron));
    addToScene(scene, std::move(embers));
}

// Thickness along the bird from tail to beak.
float birdRadius(float t) {
    const Profile through = {{0.0f, 0.02f},   {0.10f, 0.07f},  {0.24f, 0.20f},  {0.38f, 0.235f},
                             {0.50f, 0.17f},  {0.60f, 0.085f}, {0.74f, 0.062f}, {0.84f, 0.085f},
                             {0.90f, 0.062f}, {0.95f, 0.026f}, {1.0f, 0.004f}};
    for (std::size_t i = 0; i + 1 < through.size(); ++i) {
        if (t <= through[i + 1].x) {
            const float s = (t - through[i].x) / (through[i + 1].x - through[i].x);
            return glm::mix(through[i].y, through[i + 1].y, s * s * (3.0f - 2.0f * s));
        }
    }
    return through.back().y;
}

void addBird(Scene& scene, const Materials& m) {
    const glm::dmat4 stand = at({-2.05, 0.0, 4.6}, -0.75);
    MeshDraft plinth = draft("plinth", m.dressedStone);
    const Profile profile = {{0.0f, 0.0f},   {0.50f, 0.0f},  {0.50f, 0.12f}, {0.45f, 0.18f},
                             {0.36f, 0.22f}, {0.34f, 0.30f}, {0.33f, 0.62f}, {0.36f, 0.68f},
                             {0.44f, 0.74f}, {0.46f, 0.80f}, {0.46f, 0.86f}, {0.0f, 0.86f}};
    addLathe(plinth, {}, profile, 48);
    shadeFrom(plinth, 0,
              [](const Vertex& v) { return 1.0f - 0.5f * std::exp(-v.position.y / 0.2f); });
    addToScene(scene, std::move(plinth), stand);

    MeshDraft bird = draft("brassFigure", m.brass);
    const Path spine = {{-0.72f, 1.36f, 0}, {-0.42f, 1.47f, 0}, {-0.10f, 1.55f, 0},
                        {0.16f, 1.66f, 0},  {0.30f, 1.84f, 0},  {0.27f, 2.06f, 0},
                        {0.22f, 2.26f, 0},  {0.30f, 2.42f, 0},  {0.46f, 2.42f, 0},
                        {0.66f, 2.33f, 0},  {0.86f, 2.24f, 0}};
    addTube(bird, smooth(spine, 12), birdRadius, 40);
    for (const float side : {-1.0f, 1.0f}) {
        // A folded wing: a stretched and flattened sphere.
        const std::size_t first = bird.vertices.size();
        addSphere(bird, {}, 1.0f, 48);
        glm::mat4 wing = glm::translate(glm::mat4(1.0f), glm::vec3(-0.22f, 1.60f, side * 0.17f));
        wing = glm::rotate(wing, 0.30f, glm::vec3(0, 0, 1));
        wing = glm::rotate(wing, side * 0.22f, glm::vec3(0, 1, 0));
        transformFrom(bird, first, glm::scale(wing, glm::vec3(0.50f, 0.155f, 0.055f)));
        const Path leg = {{0.02f, 1.44f, side * 0.08f},
                          {-0.04f, 1.16f, side * 0.08f},
                          {0.02f, 0.86f, side * 0.09f}};
        addTube(
            bird, smooth(leg, 8), [](float t) { return 0.035f - 0.014f * t; }, 16);
        for (const float toe : {-0.5f, 0.0f, 0.5f}) {
            const Path claw = {
                {0.02f, 0.885f, side * 0.09f},
                {0.02f + 0.16f * std::cos(toe), 0.872f, side * 0.09f + 0.16f * std::sin(toe)}};
            addTube(
                bird, claw, [](float t) { return 0.020f - 0.010f * t; }, 10);
        }
    }
    addToScene(scene, std::move(bird), stand);
}

void addGlassBall(Scene& scene, const Materials& m) {
    const glm::dmat4 stand = at({2.05, 0.0, 4.6});
    MeshDraft foot = draft("ballStand", m.brass);
    const Profile profile = {{0.0f, 0.0f},    {0.30f, 0.0f},   {0.30f, 0.04f},  {0.22f, 0.09f},
                             {0.07f, 0.14f},  {0.045f, 0.24f}, {0.045f, 0.50f}, {0.09f, 0.56f},
                             {0.045f, 0.62f}, {0.045f, 0.92f}, {0.10f, 1.00f},  {0.17f, 1.06f},
                             {0.16f, 1.075f}, {0.0f, 1.04f}};
    addLathe(foot, {}, profile, 40);
    addToScene(scene, std::move(foot), stand);
    MeshDraft ball = draft("glassBall", m.glassBall);
    addSphere(ball, {0.0f, 1.46f, 0.0f}, 0.42f, 64);
    addToScene(scene, std::move(ball), stand);
}

void addPews(Scene& scene, const Materials& m) {
    MeshDraft pews = draft("pews", m.wood);
    for (int row = 0; row < 6; ++row) {
        for (const float side : {-1.0f, 1.0f}) {
            const float z = -4.6f + 1.25f * static_cast<float>(row), x0 = side > 0 ? 0.95f : -2.85f,
                        x1 = x0 + 1.9f;
            const std::size_t first = pews.vertices.size();
            addBox(pews, {x0, 0.42f, z}, {x1, 0.47f, z + 0.40f});
            addBox(pews, {x0, 0.42f, z + 0.38f}, {x1, 0.98f, z + 0.43f});
            for (const float x : {x0 - 0.05f, x1})
                addBox(pews, {x, 0.0f, z - 0.04f}, {x + 0.06f, 1.04f, z + 0.48f});
            addBox(pews, {x0, 0.12f, z + 0.02f}, {x1, 0.16f, z + 0.12f});
            shadeFrom(pews, first, [](const Vertex& v) {
                return 1.0f - 0.55f * std::exp(-v.position.y / 0.3f);
            });
        }
    }
    addToScene(scene, std::move(pews));
}

// A candle with its flame; a point light nearby illuminates the scene.
void addCandle(MeshDraft& wax, MeshDraft& flame, const glm::vec3& foot, float height) {
    const Profile stick = {{0.0f, 0.0f},
                           {0.022f, 0.0f},
                           {0.021f, height},
                           {0.014f, height - 0.008f},
                           {0.0f, height - 0.01f}};
    addLathe(wax, foot, stick, 12);
    const Profile tongue = {{0.0f, 0.0f},     {0.012f, 0.012f}, {0.016f, 0.030f},
                            {0.012f, 0.055f}, {0.005f, 0.082f}, {0.0f, 0.100f}};
    addLathe(flame, foot + glm::vec3(0, height + 0.012f, 0), tongue, 10, 1.2f);
}

void addAltar(Scene& scene, const Materials& m) {
    MeshDraft steps = draft("steps", m.dressedStone);
    for (int i = 0; i < 3; ++i) {
        const float s = static_cast<float>(i);
        addBox(steps, {-3.0f + 0.3f * s, 0.15f * s, -12.0f},
               {3.0f - 0.3f * s, 0.15f * s + 0.15f, -8.4f - 0.4f * s});
    }
    addToScene(scene, std::move(steps));
    MeshDraft stone = draft("altar", m.dressedStone), cloth = draft("altarCloth", m.cloth),
              gold = draft("altarGold", m.gold);
    addBox(stone, {-1.25f, 0.45f, -10.6f}, {1.25f, 1.40f, -9.9f});
    addBox(cloth, {-1.32f, 1.40f, -10.66f}, {1.32f, 1.43f, -9.84f});
    addBox(cloth, {-0.42f, 0.80f, -9.86f}, {0.42f, 1.42f, -9.835f});
    const Profile chalice = {{0.0f, 0.0f},    {0.11f, 0.0f},   {0.10f, 0.02f},  {0.03f, 0.05f},
                             {0.022f, 0.12f}, {0.045f, 0.15f}, {0.022f, 0.18f}, {0.04f, 0.20f},
                             {0.10f, 0.26f},  {0.115f, 0.36f}, {0.105f, 0.36f}, {0.085f, 0.27f},
                             {0.0f, 0.22f}};
    addLathe(gold, {0.0f, 1.43f, -10.2f}, chalice, 40);
    MeshDraft wax = draft("altarCandles", m.wax), flame = draft("altarFlames", m.flame);
    const Profile holder = {{0.0f, 0.0f},    {0.075f, 0.0f}, {0.07f, 0.02f}, {0.02f, 0.05f},
                            {0.016f, 0.16f}, {0.04f, 0.19f}, {0.04f, 0.20f}, {0.0f, 0.20f}};
    for (const float x : {-1.05f, -0.75f, -0.45f, 0.45f, 0.75f, 1.05f}) {
        addLathe(gold, {x, 1.43f, -10.25f}, holder, 20);
        addCandle(wax, flame, {x, 1.63f, -10.25f}, 0.22f + 0.10f * (1.05f - std::abs(x)));
    }
    for (MeshDraft* part : {&stone, &cloth, &gold, &wax, &flame})
        addToScene(scene, std::move(*part));
}

void addChandeliers(Scene& scene, const Materials& m) {
    MeshDraft iron = draft("chandelier", m.iron), wax = draft("chandelierCandles", m.wax),
              flame = draft("chandelierFlames", m.flame);
    constexpr float kRing = 0.85f, kHeight = 5.2f;
    for (const float z : {3.0f, -3.0f}) {
        Path ring;
        for (int i = 0; i < 72; ++i) {
            const float a = glm::two_pi<float>() * static_cast<float>(i) / 72.0f;
            ring.emplace_back(kRing * std::cos(a), kHeight, z + kRing * std::sin(a));
        }
        addTube(
            iron, ring, [](float) { return 0.035f; }, 10, true);
        for (int i = 0; i < 12; ++i) {
            const float a = glm::two_pi<float>() * static_cast<float>(i) / 12.0f;
            const glm::vec3 foot(kRing * std::cos(a), kHeight + 0.03f, z + kRing * std::sin(a));
            const Profile dish = {{0.0f, 0.0f}, {0.05f, 0.01f}, {0.06f, 0.03f}, {0.0f, 0.025f}};
            addLathe(iron, foot, dish, 12);
            addCandle(wax, flame, foot + glm::vec3(0, 0.03f, 0), 0.20f);
            if (i % 3 == 0) {
                const std::array chain = {
                    glm::vec3(kRing * std::cos(a), kHeight, z + kRing * std::sin(a)),
                    glm::vec3(0.0f, kHeight + 1.3f, z)};
                addTube(
                    iron, chain, [](float) { return 0.014f; }, 6);
            }
        }
        const std::array rope = {glm::vec3(0.0f, kHeight + 1.3f, z),
                                 glm::vec3(0.0f, kVault + 4.5f, z)};
        addTube(
            iron, rope, [](float) { return 0.016f; }, 6);
    }
    for (MeshDraft* part : {&iron, &wax, &flame}) addToScene(scene, std::move(*part));
}

}  // namespace

void addFurniture(Scene& scene, const Materials& materials) {
    addAltar(scene, materials);
    addPews(scene, materials);
    addBraziers(scene, materials);
    addBird(scene, materials);
    addGlassBall(scene, materials);
    addChandeliers(scene, materials);
}

}  // namespace clerestory::chapel_parts
