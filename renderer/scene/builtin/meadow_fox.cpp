// A walking fox: one skin with a skeleton and a four-beat walk cycle.
//
// The bind pose is standing, facing +X, with the feet at y = 0. It is also the rest pose, so
// inverse bind matrices are translations.
#include "scene/builtin/meadow_parts.h"
#include "scene/builtin/modelling.h"
#include "scene/builtin/motion.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory::meadow_parts {
namespace {

constexpr double kStride = 1.2;  // duration of a walk cycle, seconds
constexpr int kStridesRound = 12;
constexpr int kKeys = 24;

enum Bone : std::uint32_t {
    body,
    pelvis,
    chest,
    neck,
    head,
    tail1,
    tail2,
    tail3,
    firstLeg,  // upper, lower, foot; front left, front right, hind left, hind right
    bones = firstLeg + 12
};

struct BoneRest {
    const char* name;
    std::uint32_t parent;
    glm::dvec3 joint;  // standing, metres
};

constexpr double kHalfTrack = 0.105;

std::array<BoneRest, bones> skeleton() {
    std::array<BoneRest, bones> all{{{"fox body", bones, {0.0, 0.62, 0.0}},
                                     {"pelvis", body, {-0.28, 0.63, 0.0}},
                                     {"chest", body, {0.22, 0.60, 0.0}},
                                     {"neck", chest, {0.36, 0.68, 0.0}},
                                     {"head", neck, {0.52, 0.86, 0.0}},
                                     {"tail 1", pelvis, {-0.44, 0.66, 0.0}},
                                     {"tail 2", tail1, {-0.66, 0.58, 0.0}},
                                     {"tail 3", tail2, {-0.88, 0.50, 0.0}}}};
    const char* names[4][3] = {{"front left", "front left shin", "front left foot"},
                               {"front right", "front right shin", "front right foot"},
                               {"hind left", "hind left shin", "hind left foot"},
                               {"hind right", "hind right shin", "hind right foot"}};
    for (std::uint32_t leg = 0; leg < 4; ++leg) {
        const bool hind = leg >= 2;
        const double z = leg % 2 == 0 ? -kHalfTrack : kHalfTrack;
        const std::uint32_t first = firstLeg + 3 * leg;
        all[first] = {names[leg][0], hind ? pelvis : chest,
                      hind ? glm::dvec3(-0.30, 0.58, z) : glm::dvec3(0.24, 0.54, z)};
        all[first + 1] = {names[leg][1], first,
                          hind ? glm::dvec3(-0.25, 0.36, z) : glm::dvec3(0.22, 0.31, z)};
        all[first + 2] = {names[leg][2], first + 1,
                          hind ? glm::dvec3(-0.36, 0.16, z) : glm::dvec3(0.23, 0.10, z)};
    }
    return all;
}

// A mesh, and the influences of each of its vertices.
struct Hide {
    MeshDraft mesh;
    motion::Influences influences;

    // Assigns the vertices added since the last call to these bones: weights are linear between the
    // stops of neighbouring bones. `along` returns the coordinate of a vertex.
    struct Stop {
        std::uint32_t bone;
        float at;
    };
    void follow(std::span<const Stop> stops, const std::function<float(const glm::vec3&)>& along) {
        for (std::size_t i = influences.size(); i < mesh.vertices.size(); ++i) {
            const float at = along(mesh.vertices[i].position);
            std::size_t next = 0;
            while (next < stops.size() && stops[next].at <= at) ++next;
            if (next == 0 || next == stops.size()) {
                const std::size_t end = next == 0 ? 0 : stops.size() - 1;
                influences.push_back({{stops[end].bone, 1.0f}});
                continue;
            }
            const Stop &a = stops[next - 1], &b = stops[next];
            const float share = (at - a.at) / (b.at - a.at);
            influences.push_back({{a.bone, 1.0f - share}, {b.bone, share}});
        }
    }
    void paint(std::size_t first, const std::function<glm::vec3(const Vertex&)>& color) {
        for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
            mesh.vertices[i].color = glm::vec4(color(mesh.vertices[i]), 1.0f);
        }
    }
};

const glm::vec3 kRusset(0.62f, 0.21f, 0.045f), kCream(0.86f, 0.80f, 0.70f),
    kDark(0.045f, 0.03f, 0.025f);

float between(float low, float high, float v) {
    const float s = std::clamp((v - low) / (high - low), 0.0f, 1.0f);
    return s * s * (3.0f - 2.0f * s);
}

void addTrunk(Hide& hide) {
    const std::vector<glm::vec3> spine{{-0.47f, 0.63f, 0}, {-0.40f, 0.63f, 0}, {-0.25f, 0.62f, 0},
                                       {-0.05f, 0.60f, 0}, {0.15f, 0.58f, 0},  {0.28f, 0.60f, 0},
                                       {0.37f, 0.67f, 0},  {0.45f, 0.77f, 0},  {0.52f, 0.86f, 0}};
    const std::array<float, 9> radii{0.02f,  0.11f,  0.135f, 0.125f, 0.15f,
                                     0.145f, 0.115f, 0.085f, 0.07f};
    const std::size_t first = hide.mesh.vertices.size();
    shapes::addTube(
        hide.mesh, shapes::smooth(spine, 6),
        [&](float t) {
            const float at = t * 8.0f;
            const auto i = std::min<std::size_t>(7, static_cast<std::size_t>(at));
            return glm::mix(radii[i], radii[i + 1], between(0.0f, 1.0f, at - float(i)));
        },
        28);
    // Slightly taller than wide.
    for (std::size_t i = first; i < hide.mesh.vertices.size(); ++i) {
        hide.mesh.vertices[i].position.z *= 0.86f;
    }
    hide.paint(first, [](const Vertex& v) {
        const float below =
            between(0.35f, -0.55f, v.normal.y) * between(-0.35f, 0.2f, v.position.x);
        return glm::mix(kRusset, kCream, below * between(0.2f, 0.9f, -v.normal.y + 0.5f));
    });
    const std::array<Hide::Stop, 5> stops{
        {{pelvis, -0.26f}, {body, -0.05f}, {chest, 0.20f}, {neck, 0.40f}, {head, 0.53f}}};
    hide.follow(stops, [](const glm::vec3& p) { return p.x; });
}

void addHead(Hide& hide) {
    const std::size_t first = hide.mesh.vertices.size();
    const std::vector<glm::vec3> axis{{0.44f, 0.88f, 0}, {0.47f, 0.89f, 0}, {0.55f, 0.90f, 0},
                                      {0.63f, 0.87f, 0}, {0.72f, 0.83f, 0}, {0.80f, 0.81f, 0},
                                      {0.82f, 0.81f, 0}};
    const std::array<float, 7> radii{0.01f, 0.075f, 0.105f, 0.085f, 0.045f, 0.026f, 0.006f};
    shapes::addTube(
        hide.mesh, shapes::smooth(axis, 6),
        [&](float t) {
            const float at = t * 6.0f;
            const auto i = std::min<std::size_t>(5, static_cast<std::size_t>(at));
            return glm::mix(radii[i], radii[i + 1], between(0.0f, 1.0f, at - float(i)));
        },
        24);
    hide.paint(first, [](const Vertex& v) {
        if (v.position.x > 0.795f) return kDark;
        const float cheek = between(0.1f, -0.35f, v.normal.y);
        return glm::mix(kRusset, kCream, cheek);
    });
    for (const float side : {-1.0f, 1.0f}) {
        const std::size_t ear = hide.mesh.vertices.size();
        const std::vector<glm::vec3> upright{{0.53f, 0.95f, 0.06f * side},
                                             {0.52f, 1.02f, 0.075f * side},
                                             {0.51f, 1.09f, 0.085f * side}};
        shapes::addTube(
            hide.mesh, shapes::smooth(upright, 4),
            [](float t) { return 0.048f * (1.0f - t) + 0.004f; }, 12);
        hide.paint(ear, [](const Vertex& v) {
            return glm::mix(kRusset, kDark, between(1.0f, 1.06f, v.position.y));
        });
        const std::size_t eye = hide.mesh.vertices.size();
        shapes::addSphere(hide.mesh, {0.645f, 0.905f, 0.062f * side}, 0.016f, 12);
        hide.paint(eye, [](const Vertex&) { return kDark; });
    }
    const std::array<Hide::Stop, 1> stops{{{head, 0.0f}}};
    hide.follow(stops, [](const glm::vec3&) { return 0.0f; });
}

void addTail(Hide& hide) {
    const std::size_t first = hide.mesh.vertices.size();
    const std::vector<glm::vec3> axis{{-0.40f, 0.66f, 0}, {-0.50f, 0.645f, 0}, {-0.66f, 0.58f, 0},
                                      {-0.82f, 0.52f, 0}, {-0.98f, 0.48f, 0},  {-1.10f, 0.47f, 0}};
    const std::array<float, 6> radii{0.045f, 0.05f, 0.085f, 0.10f, 0.07f, 0.006f};
    shapes::addTube(
        hide.mesh, shapes::smooth(axis, 6),
        [&](float t) {
            const float at = t * 5.0f;
            const auto i = std::min<std::size_t>(4, static_cast<std::size_t>(at));
            return glm::mix(radii[i], radii[i + 1], between(0.0f, 1.0f, at - float(i)));
        },
        20);
    hide.paint(first, [](const Vertex& v) {
        return glm::mix(kRusset, kCream, between(-0.90f, -0.99f, v.position.x));
    });
    const std::array<Hide::Stop, 4> stops{
        {{pelvis, 0.42f}, {tail1, 0.52f}, {tail2, 0.72f}, {tail3, 0.92f}}};
    hide.follow(stops, [](const glm::vec3& p) { return -p.x; });
}

void addLeg(Hide& hide, std::uint32_t leg, const std::array<BoneRest, bones>& rest) {
    const std::uint32_t first = firstLeg + 3 * leg;
    const bool hind = leg >= 2;
    const std::size_t start = hide.mesh.vertices.size();
    const glm::vec3 hip(rest[first].joint), knee(rest[first + 1].joint),
        foot(rest[first + 2].joint);
    const std::vector<glm::vec3> axis{hip + glm::vec3(0, 0.05f, 0), hip, knee, foot,
                                      foot + glm::vec3(0.015f, -0.10f, 0)};
    const std::array<float, 5> radii{0.05f, hind ? 0.085f : 0.065f, 0.042f, 0.03f, 0.034f};
    shapes::addTube(
        hide.mesh, shapes::smooth(axis, 6),
        [&](float t) {
            const float at = t * 4.0f;
            const auto i = std::min<std::size_t>(3, static_cast<std::size_t>(at));
            return glm::mix(radii[i], radii[i + 1], between(0.0f, 1.0f, at - float(i)));
        },
        16);
    const std::size_t paw = hide.mesh.vertices.size();
    shapes::addSphere(hide.mesh, {0, 0, 0}, 1.0f, 14);
    shapes::transformFrom(
        hide.mesh, paw,
        glm::scale(glm::translate(glm::mat4(1.0f), foot + glm::vec3(0.035f, -0.075f, 0)),
                   {0.062f, 0.030f, 0.042f}));
    hide.paint(start, [](const Vertex& v) {
        return glm::mix(kDark, kRusset, between(0.20f, 0.36f, v.position.y));
    });
    // Downwards; about a third of each bone is blended with its neighbour.
    const float y0 = hip.y, y1 = knee.y, y2 = foot.y;
    const std::array<Hide::Stop, 6> stops{{{hind ? pelvis : chest, -(y0 + 0.06f)},
                                           {first, -(y0 - 0.02f)},
                                           {first, -(y1 + 0.04f)},
                                           {first + 1, -(y1 - 0.03f)},
                                           {first + 1, -(y2 + 0.03f)},
                                           {first + 2, -(y2 - 0.02f)}}};
    hide.follow(stops, [](const glm::vec3& p) { return -p.y; });
}

// The rotation of a bone at a fraction of the stride, about its joint. z: in the sagittal plane,
// positive forwards and up; y: to the left.
glm::dvec2 bend(std::uint32_t bone, double share) {
    const auto wave = [&](double times, double shift) {
        return std::sin(glm::two_pi<double>() * (times * share + shift));
    };
    switch (bone) {
        case pelvis:
            return {0.03 * wave(2, 0.1), 0.07 * wave(1, 0.0)};
        case chest:
            return {0.03 * wave(2, 0.35), 0.06 * wave(1, 0.5)};
        case neck:
            return {0.06 * wave(2, 0.2), -0.05 * wave(1, 0.5)};
        case head:
            return {-0.05 * wave(2, 0.25), 0.04 * wave(1, 0.55)};
        case tail1:
            return {0.05 * wave(2, 0.0), 0.16 * wave(1, 0.1)};
        case tail2:
            return {0.06 * wave(2, 0.9), 0.20 * wave(1, 0.95)};
        case tail3:
            return {0.07 * wave(2, 0.8), 0.22 * wave(1, 0.8)};
        default:
            break;
    }
    if (bone < firstLeg) return {0.0, 0.0};
    const std::uint32_t leg = (bone - firstLeg) / 3, part = (bone - firstLeg) % 3;
    const bool hind = leg >= 2;
    // Hind left, front left, hind right, front right: the four beats of a walk.
    constexpr std::array<double, 4> kBeat{0.25, 0.75, 0.0, 0.5};
    const double at = share + kBeat[leg];
    const double swing = std::sin(glm::two_pi<double>() * at);
    // 1 in the middle of the swing phase, 0 in the stance phase.
    const double lift = std::pow(std::max(0.0, std::cos(glm::two_pi<double>() * at)), 1.5);
    if (part == 0) return {(hind ? 0.36 : 0.40) * swing + 0.10 * lift, 0.0};
    if (part == 1) return {(hind ? -0.55 : -0.80) * lift - 0.06 * swing, 0.0};
    return {(hind ? 0.35 : -0.45) * lift - 0.22 * swing, 0.0};
}

}  // namespace

void addFox(Scene& scene) {
    const std::array<BoneRest, bones> rest = skeleton();
    scene.materials.push_back(
        {.name = "fur", .metallic = 0.0f, .roughness = 0.9f, .specular = 0.5f});
    Hide hide{shapes::draft("fox", static_cast<Index>(scene.materials.size() - 1)), {}};
    addTrunk(hide);
    addHead(hide);
    addTail(hide);
    for (std::uint32_t leg = 0; leg < 4; ++leg) addLeg(hide, leg, rest);

    // A node rotates around the centre of the path; the fox is on the path and faces along it.
    const Index way = addNode(scene, "fox's way");
    Transform start;
    start.rotation = glm::angleAxis(-0.8, glm::dvec3(0, 1, 0));
    const Index wayMoves = motion::addMovingNode(scene, way, start);
    const Index stand =
        addNode(scene, "fox", glm::translate(glm::dmat4(1.0), {0.0, 0.0, kPathRadius}), way);
    Skin skin;
    std::vector<Index> moving;
    for (std::uint32_t b = 0; b < bones; ++b) {
        const bool isRoot = rest[b].parent == bones;
        const glm::dvec3 from = isRoot ? glm::dvec3(0.0) : rest[rest[b].parent].joint;
        const Index parent = isRoot ? stand : skin.joints[rest[b].parent];
        const Index node = addNode(scene, rest[b].name, glm::dmat4(1.0), parent);
        moving.push_back(motion::addMovingNode(scene, node, {.translation = rest[b].joint - from}));
        skin.joints.push_back(node);
        skin.jointFromMesh.push_back(glm::translate(glm::dmat4(1.0), -rest[b].joint));
    }
    motion::placeSkinned(scene, std::move(hide.mesh), hide.influences, std::move(skin));

    Clip walk{"walk", kStride, {}};
    for (std::uint32_t b = 1; b < bones; ++b) {
        walk.tracks.push_back(
            motion::repeating(AnimatedProperty::rotation, moving[b], kStride, kKeys, [&](double t) {
                const glm::dvec2 angles = bend(b, t / kStride);
                return motion::numbers(glm::angleAxis(angles.y, glm::dvec3(0, 1, 0)) *
                                       glm::angleAxis(angles.x, glm::dvec3(0, 0, 1)));
            }));
    }
    const glm::dvec3 back = rest[body].joint;
    walk.tracks.push_back(motion::repeating(
        AnimatedProperty::translation, moving[body], kStride, kKeys, [&](double t) {
            const double turn = 2.0 * glm::two_pi<double>() * t / kStride;
            return motion::numbers(back + glm::dvec3(0.0, 0.012 * std::sin(turn) - 0.02, 0.0));
        }));
    scene.clips.push_back(std::move(walk));
    const double round = kStridesRound * kStride;
    scene.clips.push_back(
        {"round", round, {motion::turning(scene, wayMoves, {0, 1, 0}, 1, round)}});
}

}  // namespace clerestory::meadow_parts
