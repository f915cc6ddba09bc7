// Walls with pointed openings, columns, vaults, floor and windows.
#include "scene/builtin/chapel_parts.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory::chapel_parts {
namespace {

using namespace shapes;

constexpr float kHalfLength = 0.5f * kLength;
constexpr float kInner = kColumn - kWall, kOuter = kColumn + kWall;
constexpr float kNaveRadius = 5.0f, kAisleHalf = 0.5f * (kAisle - kOuter), kAisleRadius = 1.75f;

// The relative brightness at `distance` from a corner: darker within `reach` metres.
float corner(float distance, float reach, float depth) {
    return 1.0f - depth * std::exp(-std::max(0.0f, distance) / reach);
}

// Wall coordinates: u along the wall, y up, seen from the side of its normal.
struct Wall {
    glm::vec3 origin, along, normal;

    glm::vec3 at(float u, float y, float depth = 0.0f) const {
        return origin + u * along + glm::vec3(0, y, 0) - depth * normal;
    }
};

using Height = std::function<float(float)>;

// The part of a wall between two heights, from u0 to u1.
void addCurtain(MeshDraft& mesh, const Wall& wall, float u0, float u1, const Height& lower,
                const Height& upper) {
    const int columns = std::max(1, static_cast<int>(std::ceil((u1 - u0) / 0.3f)));
    const std::size_t first = mesh.vertices.size();
    addGrid(mesh, columns, 4, glm::vec2(1.0f), [&](float s, float t) {
        const float u = glm::mix(u0, u1, s);
        return GridPoint{wall.at(u, glm::mix(lower(u), std::max(lower(u), upper(u)), t)),
                         wall.normal};
    });
    for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
        Vertex& v = mesh.vertices[i];
        v.texCoord0 = {glm::dot(v.position - wall.origin, wall.along), v.position.y};
    }
    shadeFrom(mesh, first, [](const Vertex& v) { return corner(v.position.y, 0.5f, 0.45f); });
}

// The outline of an opening from the lower left over the top to the lower right; a whole circle for
// round openings.
std::vector<glm::vec2> outline(const Opening& o) {
    std::vector<glm::vec2> points;
    constexpr int kSteps = 36;
    if (o.radius == 0.0f) {
        for (int i = 0; i <= 2 * kSteps; ++i) {
            const float a = glm::two_pi<float>() * static_cast<float>(i) / (2 * kSteps);
            points.emplace_back(o.center - o.half * std::cos(a), o.spring + o.half * std::sin(a));
        }
        return points;
    }
    points.emplace_back(o.center - o.half, o.bottom);
    for (int i = 0; i <= kSteps; ++i) {
        // Denser near the springing line, where the arch is steep.
        const float s = -std::cos(glm::pi<float>() * static_cast<float>(i) / kSteps);
        points.emplace_back(o.center + s * o.half,
                            o.spring + pointedArch(s * o.half, o.half, o.radius));
    }
    points.emplace_back(o.center + o.half, o.bottom);
    return points;
}

// The reveal of an opening: the thickness of the wall.
void addReveal(MeshDraft& mesh, const Wall& wall, const Opening& o, float depth) {
    std::vector<glm::vec2> points = outline(o);
    if (o.glass != kNone && o.radius > 0.0f) points.push_back(points.front());  // the sill
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const glm::vec2 a = points[i], b = points[i + 1];
        if (glm::length(b - a) < 1e-4f) continue;
        // Towards the opening, on the right of the outline, which is clockwise.
        const glm::vec2 d = glm::normalize(b - a);
        const glm::vec3 inwards = glm::normalize(d.y * wall.along + glm::vec3(0, -d.x, 0));
        addGrid(mesh, 1, 1, {glm::length(b - a), depth}, [&](float s, float t) {
            const glm::vec2 p = glm::mix(a, b, s);
            return GridPoint{wall.at(p.x, p.y, (1.0f - t) * depth), inwards};
        });
    }
}

void addGlass(Scene& scene, const Wall& wall, const Opening& o, float depth) {
    MeshDraft pane = draft("window", o.glass);
    const bool circle = o.radius == 0.0f;
    const float low = circle ? o.spring - o.half : o.bottom;
    // A lancet's texture is four times as high as wide and begins at the sill; the arch clips it.
    const float height = (circle ? 2.0f : 8.0f) * o.half;
    addGrid(pane, 32, 1, glm::vec2(1.0f), [&](float s, float t) {
        const float u = o.center + (2.0f * s - 1.0f) * o.half;
        return GridPoint{wall.at(u, glm::mix(o.lower(u), o.upper(u), t), depth), wall.normal};
    });
    for (Vertex& v : pane.vertices) {
        const float u = glm::dot(v.position - wall.origin, wall.along);
        v.texCoord0 = {(u - o.center) / (2.0f * o.half) + 0.5f,
                       1.0f - (v.position.y - low) / height};
    }
    addToScene(scene, std::move(pane));
}

// A raised moulding along an opening's edge, and a mullion or the bars of a rose.
void addTracery(MeshDraft& mesh, const Wall& wall, const Opening& o, float depth) {
    const auto bar = [&](const std::vector<glm::vec3>& path, float thickness, bool closed = false) {
        addTube(
            mesh, path, [&](float) { return thickness; }, 8, closed);
    };
    std::vector<glm::vec3> edge;
    for (const glm::vec2& p : outline(o)) {
        const glm::vec3 q = wall.at(p.x, p.y, -0.02f);
        if (edge.empty() || glm::length(q - edge.back()) > 0.02f) edge.push_back(q);
    }
    const bool circle = o.radius == 0.0f;
    if (circle) edge.pop_back();
    bar(edge, 0.07f, circle);
    if (o.glass == kNone) return;
    const float inside = depth - 0.03f;
    if (!circle) {
        bar({wall.at(o.center, o.bottom, inside), wall.at(o.center, o.upper(o.center), inside)},
            0.035f);
        return;
    }
    for (const float r : {0.20f, 0.52f, 0.78f}) {
        std::vector<glm::vec3> ring;
        for (int i = 0; i < 64; ++i) {
            const float a = glm::two_pi<float>() * static_cast<float>(i) / 64.0f;
            ring.push_back(wall.at(o.center + r * o.half * std::cos(a),
                                   o.spring + r * o.half * std::sin(a), inside));
        }
        bar(ring, 0.04f, true);
    }
    for (int i = 0; i < 12; ++i) {
        const float a = glm::two_pi<float>() * static_cast<float>(i) / 12.0f;
        const auto spoke = [&](float r) {
            return wall.at(o.center + r * o.half * std::cos(a), o.spring + r * o.half * std::sin(a),
                           inside);
        };
        bar({spoke(0.20f), spoke(1.0f)}, 0.04f);
    }
}

// A wall from u0 to u1 up to `top`, with openings that may be above each other.
void addWall(Scene& scene, MeshDraft& mesh, MeshDraft& tracery, const Wall& wall, float u0,
             float u1, const Height& bottom, const Height& top,
             const std::vector<Opening>& openings, float depth) {
    std::vector<float> cuts = {u0, u1};
    for (const Opening& o : openings) {
        cuts.push_back(o.center - o.half);
        cuts.push_back(o.center + o.half);
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const float a = std::max(u0, cuts[i]), b = std::min(u1, cuts[i + 1]),
                    middle = 0.5f * (a + b);
        if (b - a < 1e-4f) continue;
        std::vector<const Opening*> through;
        for (const Opening& o : openings) {
            if (std::abs(middle - o.center) < o.half) through.push_back(&o);
        }
        std::sort(through.begin(), through.end(),
                  [](const Opening* l, const Opening* r) { return l->bottom < r->bottom; });
        Height from = bottom;
        for (const Opening* o : through) {
            if (o->glass != kNone)
                addCurtain(mesh, wall, a, b, from, [o](float u) { return o->lower(u); });
            from = [o](float u) { return o->upper(u); };
        }
        addCurtain(mesh, wall, a, b, from, top);
    }
    for (const Opening& o : openings) {
        addReveal(mesh, wall, o, depth);
        addTracery(tracery, wall, o, depth);
        if (o.glass != kNone) addGlass(scene, wall, o, depth);
    }
}

// A pointed barrel along Z over [center - half, center + half].
void addBarrel(MeshDraft& mesh, float center, float half, float radius, float spring) {
    for (const float side : {-1.0f, 1.0f}) {
        const float apex = std::acos((radius - half) / radius);
        addGrid(mesh, kBays * 6, 14, {kLength, apex * radius}, [&](float s, float t) {
            const float a = apex * t;
            const glm::vec2 p(radius * std::cos(a) - (radius - half), radius * std::sin(a));
            return GridPoint{{center + side * p.x, spring + p.y, kHalfLength - s * kLength},
                             {-side * std::cos(a), -std::sin(a), 0.0f}};
        });
    }
}

void addVaults(Scene& scene, const Materials& m) {
    MeshDraft vault = draft("vault", m.stone);
    addBarrel(vault, 0.0f, kInner, kNaveRadius, kVault);
    for (const float side : {-1.0f, 1.0f})
        addBarrel(vault, side * 0.5f * (kAisle + kOuter), kAisleHalf, kAisleRadius, kAisleVault);
    shadeFrom(vault, 0, [](const Vertex& v) { return v.position.y > kVault - 0.1f ? 0.9f : 0.7f; });
    addToScene(scene, std::move(vault));

    // Ribs just below the vault: transverse at the columns, diagonal over each bay, and along the
    // ridge.
    MeshDraft ribs = draft("ribs", m.dressedStone);
    const auto under = [&](float x, float z) {
        return glm::vec3(
            x, kVault + pointedArch(std::clamp(x, -kInner, kInner), kInner, kNaveRadius) - 0.05f,
            z);
    };
    const auto rib = [&](float z0, float z1, float thickness) {
        std::vector<glm::vec3> path;
        for (int i = 0; i <= 32; ++i) {
            const float s = -std::cos(glm::pi<float>() * static_cast<float>(i) / 32.0f);
            path.push_back(under(0.995f * s * kInner, glm::mix(z0, z1, 0.5f + 0.5f * s)));
        }
        addTube(
            ribs, path, [&](float) { return thickness; }, 8);
    };
    for (int i = 0; i <= kBays; ++i) {
        const float z = -kHalfLength + static_cast<float>(i) * kBay;
        rib(z, z, 0.17f);
        if (i < kBays) {
            rib(z, z + kBay, 0.11f);
            rib(z + kBay, z, 0.11f);
        }
    }
    const std::array ridge = {under(0, -kHalfLength), under(0, kHalfLength)};
    addTube(
        ribs, ridge, [](float) { return 0.10f; }, 10);
    addToScene(scene, std::move(ribs));
}

void addColumns(Scene& scene, const Materials& m) {
    // Plinth, torus, shaft with a slight belly, collar and bell capital.
    const std::vector<glm::vec2> base = {{0.0f, 0.0f},   {0.56f, 0.0f},  {0.56f, 0.16f},
                                         {0.54f, 0.20f}, {0.57f, 0.25f}, {0.54f, 0.31f},
                                         {0.46f, 0.34f}, {0.44f, 0.40f}, {0.38f, 0.44f}};
    const std::vector<glm::vec2> capital = {{0.33f, 3.46f},    {0.37f, 3.50f},  {0.37f, 3.55f},
                                            {0.33f, 3.58f},    {0.35f, 3.72f},  {0.42f, 3.88f},
                                            {0.53f, 3.98f},    {0.53f, 4.02f},  {0.58f, 4.04f},
                                            {0.58f, kCapital}, {0.0f, kCapital}};
    std::vector<glm::vec2> profile = base;
    for (int i = 0; i <= 8; ++i) {
        const float t = static_cast<float>(i) / 8.0f;
        profile.emplace_back(0.36f - 0.03f * t + 0.012f * std::sin(glm::pi<float>() * t),
                             glm::mix(0.46f, 3.42f, t));
    }
    profile.insert(profile.end(), capital.begin(), capital.end());
    MeshDraft columns = draft("columns", m.dressedStone);
    for (int i = 0; i <= kBays; ++i) {
        for (const float side : {-1.0f, 1.0f}) {
            const std::size_t first = columns.vertices.size();
            addLathe(columns, {side * kColumn, 0.0f, -kHalfLength + static_cast<float>(i) * kBay},
                     profile, 28);
            // A slender shaft continues up the wall to the ribs.
            const std::array shaft = {glm::vec3(side * (kInner - 0.02f), kCapital,
                                                -kHalfLength + static_cast<float>(i) * kBay),
                                      glm::vec3(side * (kInner - 0.02f), kVault,
                                                -kHalfLength + static_cast<float>(i) * kBay)};
            addTube(
                columns, shaft, [](float) { return 0.16f; }, 12);
            shadeFrom(columns, first,
                      [](const Vertex& v) { return corner(v.position.y, 0.35f, 0.5f); });
        }
    }
    addToScene(scene, std::move(columns));
}

void addWalls(Scene& scene, const Materials& m) {
    MeshDraft walls = draft("walls", m.stone), tracery = draft("tracery", m.dressedStone);
    std::vector<Opening> arcade, clerestory, aisle;
    for (int i = 0; i < kBays; ++i) {
        const float u = (static_cast<float>(i) + 0.5f) * kBay;
        arcade.push_back({u, 1.58f, kCapital, kCapital, 2.3f});
        clerestory.push_back({u, 0.85f, 7.3f, 9.0f, 1.5f, m.lancets[(i + 1) % 3]});
        aisle.push_back({u, 0.8f, 1.5f, 4.3f, 1.5f, m.lancets[i % 3]});
    }
    const auto level = [](float y) { return [y](float) { return y; }; };
    std::vector<Opening> nave = arcade;
    nave.insert(nave.end(), clerestory.begin(), clerestory.end());
    for (const float side : {-1.0f, 1.0f}) {
        const Wall inner{{side * kInner, 0, -kHalfLength}, {0, 0, 1}, {-side, 0, 0}};
        addWall(scene, walls, tracery, inner, 0.0f, kLength, level(kCapital), level(kVault), nave,
                0.28f);
        const Wall back{{side * kOuter, 0, -kHalfLength}, {0, 0, 1}, {side, 0, 0}};
        addWall(scene, walls, tracery, back, 0.0f, kLength, level(kCapital), level(kAisleVault),
                arcade, 0.33f);
        const Wall outer{{side * kAisle, 0, -kHalfLength}, {0, 0, 1}, {-side, 0, 0}};
        std::vector<Opening> openings = aisle;
        if (side > 0.0f) openings[kDoorBay] = {kDoorZ + kHalfLength, 1.05f, 0.0f, 2.5f, 1.7f};
        addWall(scene, walls, tracery, outer, 0.0f, kLength, level(0.0f), level(kAisleVault),
                openings, kOuterWall);
    }

    // End walls extend behind the vaults: differently tessellated curves would leave gaps.
    constexpr float kBehindVault = 0.3f;
    const Height naveTop = [](float u) {
        return kBehindVault + kVault +
               pointedArch(std::clamp(u, -kInner, kInner), kInner, kNaveRadius);
    };
    const Height aisleTop = [](float u) {
        return kBehindVault + kAisleVault +
               pointedArch(
                   std::clamp(std::abs(u) - 0.5f * (kAisle + kOuter), -kAisleHalf, kAisleHalf),
                   kAisleHalf, kAisleRadius);
    };
    const std::vector<Opening> altarWindows = {{-2.0f, 0.62f, 2.7f, 5.3f, 1.15f, m.lancets[1]},
                                               {0.0f, 0.72f, 2.7f, 5.9f, 1.35f, m.lancets[0]},
                                               {2.0f, 0.62f, 2.7f, 5.3f, 1.15f, m.lancets[2]},
                                               {0.0f, 2.25f, 7.55f, 9.8f, 0.0f, m.rose}};
    for (const float end : {-1.0f, 1.0f}) {
        const Wall wall{{0, 0, end * kHalfLength}, {1, 0, 0}, {0, 0, -end}};
        addWall(scene, walls, tracery, wall, -kInner, kInner, level(0.0f), naveTop,
                end < 0.0f ? altarWindows : std::vector<Opening>{}, 0.3f);
        for (const float side : {-1.0f, 1.0f}) {
            addWall(scene, walls, tracery, wall, std::min(side * kOuter, side * kAisle),
                    std::max(side * kOuter, side * kAisle), level(0.0f), aisleTop, {}, 0.3f);
            addWall(scene, walls, tracery, wall, std::min(side * kInner, side * kOuter),
                    std::max(side * kInner, side * kOuter), level(0.0f), level(kAisleVault), {},
                    0.3f);
        }
    }
    addToScene(scene, std::move(walls));
    addToScene(scene, std::move(tracery));
}

// Objects that darken the floor: x, z and radius of each base. See addFurniture.
constexpr glm::vec3 kFeet[] = {{-2.05f, 4.6f, 0.5f}, {2.05f, 4.6f, 0.3f},   {-2.55f, 7.0f, 0.2f},
                               {2.55f, 7.0f, 0.2f},  {-2.55f, -7.0f, 0.2f}, {2.55f, -7.0f, 0.2f}};

void addFloor(Scene& scene, const Materials& m) {
    MeshDraft floor = draft("floor", m.floor);
    addPatch(floor, {-kAisle, 0, kHalfLength}, {2 * kAisle, 0, 0}, {0, 0, -kLength}, 53, 96);
    shadeFrom(floor, 0, [](const Vertex& v) {
        float shade = corner(kAisle - std::abs(v.position.x), 0.5f, 0.45f) *
                      corner(kHalfLength - std::abs(v.position.z), 0.5f, 0.45f);
        const float bay = std::round((v.position.z + kHalfLength) / kBay) * kBay - kHalfLength;
        const float d = std::hypot(std::abs(v.position.x) - kColumn, v.position.z - bay) - 0.56f;
        for (const glm::vec3& foot : kFeet) {
            const glm::vec2 away(v.position.x - foot.x, v.position.z - foot.y);
            shade *= corner(glm::length(away) - foot.z, 0.22f, 0.5f);
        }
        const float pew = std::max(std::abs(std::abs(v.position.x) - 1.9f) - 0.95f,
                                   std::abs(v.position.z + 1.2f) - 3.4f);
        return shade * corner(d, 0.25f, 0.45f) * corner(pew, 0.2f, 0.4f);
    });
    addToScene(scene, std::move(floor));
}

}  // namespace

float pointedArch(float x, float half, float radius) {
    const float reach = std::min(std::abs(x), half) + radius - half;
    return std::sqrt(std::max(0.0f, radius * radius - reach * reach));
}

float Opening::lower(float u) const {
    if (radius > 0.0f) return bottom;
    return spring - std::sqrt(std::max(0.0f, half * half - (u - center) * (u - center)));
}

float Opening::upper(float u) const {
    if (radius > 0.0f) return spring + pointedArch(u - center, half, radius);
    return spring + std::sqrt(std::max(0.0f, half * half - (u - center) * (u - center)));
}

void addMasonry(Scene& scene, const Materials& materials) {
    addFloor(scene, materials);
    addWalls(scene, materials);
    addColumns(scene, materials);
    addVaults(scene, materials);
}

}  // namespace clerestory::chapel_parts
