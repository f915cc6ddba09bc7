#include "scene/builtin/modelling.h"

#include "scene/texture_images.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_inverse.hpp>

#include <array>
#include <cmath>
#include <thread>

namespace clerestory::shapes {
namespace {

std::uint32_t size(const MeshDraft& mesh) {
    return static_cast<std::uint32_t>(mesh.vertices.size());
}

void addVertex(MeshDraft& mesh, const glm::vec3& position, const glm::vec3& normal,
               const glm::vec2& uv) {
    Vertex v;
    v.position = position;
    v.normal = normal;
    v.texCoord0 = v.texCoord1 = uv;
    mesh.vertices.push_back(v);
}

// Triangles of a grid of (columns + 1) x (rows + 1) vertices that starts at `first`. The front of
// each cell is the side of its normals.
void joinGrid(MeshDraft& mesh, std::uint32_t first, int columns, int rows) {
    const auto stride = static_cast<std::uint32_t>(columns) + 1;
    for (std::uint32_t r = 0; r < static_cast<std::uint32_t>(rows); ++r) {
        for (std::uint32_t c = 0; c < static_cast<std::uint32_t>(columns); ++c) {
            const std::uint32_t a = first + r * stride + c, b = a + 1, d = a + stride, e = d + 1;
            const auto at = [&](std::uint32_t i) { return mesh.vertices[i].position; };
            const auto normal = [&](std::uint32_t i) { return mesh.vertices[i].normal; };
            const glm::vec3 across = glm::cross(at(e) - at(a), at(d) - at(b));
            const bool turned =
                glm::dot(across, normal(a) + normal(b) + normal(d) + normal(e)) < 0.0f;
            const auto triangle = [&](const std::array<std::uint32_t, 3>& t) {
                if (at(t[0]) == at(t[1]) || at(t[1]) == at(t[2]) || at(t[2]) == at(t[0])) return;
                mesh.indices.insert(mesh.indices.end(), t.begin(),
                                    t.end());  // skips degenerate triangles at a pole
            };
            triangle(turned ? std::array{a, e, b} : std::array{a, b, e});
            triangle(turned ? std::array{a, d, e} : std::array{a, e, d});
        }
    }
}

template <class Point>
std::vector<Point> catmullRom(std::span<const Point> p, int steps) {
    std::vector<Point> result;
    for (std::size_t i = 0; i + 1 < p.size(); ++i) {
        const Point a = p[i > 0 ? i - 1 : 0], b = p[i], c = p[i + 1],
                    d = p[std::min(i + 2, p.size() - 1)];
        for (int s = 0; s < steps; ++s) {
            const float t = static_cast<float>(s) / static_cast<float>(steps);
            result.push_back(0.5f * ((2.0f * b) + t * (c - a) +
                                     t * t * (2.0f * a - 5.0f * b + 4.0f * c - d) +
                                     t * t * t * (3.0f * b - a - 3.0f * c + d)));
        }
    }
    result.push_back(p.back());
    return result;
}

glm::vec3 perpendicularTo(const glm::vec3& direction) {
    const glm::vec3 axis = std::abs(direction.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
    return glm::normalize(glm::cross(direction, axis));
}

}  // namespace

MeshDraft draft(std::string name, Index material) {
    return {
        .name = std::move(name), .material = material, .hasNormals = true, .hasTexCoords = true};
}

void addGrid(MeshDraft& mesh, int columns, int rows, const glm::vec2& textureSize,
             const std::function<GridPoint(float u, float v)>& surface) {
    const std::uint32_t first = size(mesh);
    for (int r = 0; r <= rows; ++r) {
        for (int c = 0; c <= columns; ++c) {
            const glm::vec2 uv(static_cast<float>(c) / static_cast<float>(columns),
                               static_cast<float>(r) / static_cast<float>(rows));
            const GridPoint point = surface(uv.x, uv.y);
            addVertex(mesh, point.position, point.normal, uv * textureSize);
        }
    }
    joinGrid(mesh, first, columns, rows);
}

void addPatch(MeshDraft& mesh, const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v,
              int columns, int rows) {
    const glm::vec3 normal = glm::normalize(glm::cross(u, v));
    addGrid(mesh, columns, rows, {glm::length(u), glm::length(v)}, [&](float s, float t) {
        return GridPoint{corner + s * u + t * v, normal};
    });
}

void addBox(MeshDraft& mesh, const glm::vec3& min, const glm::vec3& max) {
    const glm::vec3 d = max - min, x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
    addPatch(mesh, min + z, x, y);       // +Z
    addPatch(mesh, min + x, -x, y);      // -Z
    addPatch(mesh, min + x + z, -z, y);  // +X
    addPatch(mesh, min, z, y);           // -X
    addPatch(mesh, min + y + z, x, -z);  // +Y
    addPatch(mesh, min, x, z);           // -Y
}

void addLathe(MeshDraft& mesh, const glm::vec3& foot, std::span<const glm::vec2> profile,
              int segments, float crease) {
    // Outward normals of the profile's segments: the direction rotated clockwise.
    std::vector<glm::vec2> normals;
    float length = 0.0f;
    std::vector<float> along{0.0f};
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const glm::vec2 d = profile[i + 1] - profile[i];
        const float l = glm::length(d);
        normals.push_back(l > 0.0f ? glm::vec2(d.y, -d.x) / l : glm::vec2(1, 0));
        along.push_back(length += l);
    }
    const auto joins = [&](std::size_t i) {  // whether segments i - 1 and i join smoothly
        return i > 0 && i < normals.size() &&
               glm::dot(normals[i - 1], normals[i]) > std::cos(crease);
    };
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const glm::vec2 lower = joins(i) ? glm::normalize(normals[i - 1] + normals[i]) : normals[i];
        const glm::vec2 upper =
            joins(i + 1) ? glm::normalize(normals[i] + normals[i + 1]) : normals[i];
        const float radius = std::max(profile[i].x, profile[i + 1].x);
        const std::uint32_t first = size(mesh);
        for (int r = 0; r < 2; ++r) {
            const glm::vec2 p = profile[i + static_cast<std::size_t>(r)], n = r ? upper : lower;
            for (int s = 0; s <= segments; ++s) {
                const float turn = static_cast<float>(s) / static_cast<float>(segments);
                const float a = glm::two_pi<float>() * turn;
                const float x = std::sin(a), z = std::cos(a);
                addVertex(
                    mesh, foot + glm::vec3(p.x * x, p.y, p.x * z), glm::vec3(n.x * x, n.y, n.x * z),
                    {turn * glm::two_pi<float>() * radius, along[i + static_cast<std::size_t>(r)]});
            }
        }
        joinGrid(mesh, first, segments, 1);
    }
}

void addSphere(MeshDraft& mesh, const glm::vec3& center, float radius, int segments) {
    std::vector<glm::vec2> profile;
    const int rings = segments / 2;
    for (int i = 0; i <= rings; ++i) {
        const float a =
            glm::pi<float>() * (static_cast<float>(i) / static_cast<float>(rings) - 0.5f);
        profile.emplace_back(i == 0 || i == rings ? 0.0f : radius * std::cos(a),
                             radius * std::sin(a));
    }
    const std::size_t first = mesh.vertices.size();
    addLathe(mesh, center, profile, segments, 3.0f);
    for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
        mesh.vertices[i].normal = glm::normalize(mesh.vertices[i].position - center);
    }
}

void addTube(MeshDraft& mesh, std::span<const glm::vec3> path,
             const std::function<float(float)>& radius, int sides, bool closed) {
    const std::size_t count = path.size();
    const auto at = [&](std::size_t i) {
        return path[closed ? i % count : std::min(i, count - 1)];
    };
    const std::size_t rings = closed ? count + 1 : count;
    const std::uint32_t first = size(mesh);
    glm::vec3 side(0.0f);
    float along = 0.0f;
    for (std::size_t i = 0; i < rings; ++i) {
        const glm::vec3 before = closed ? at(i + count - 1) : at(i > 0 ? i - 1 : 0);
        const glm::vec3 direction = glm::normalize(at(i + 1) - before);
        // Parallel transport from the previous ring.
        side = i == 0 ? perpendicularTo(direction)
                      : glm::normalize(side - glm::dot(side, direction) * direction);
        const glm::vec3 up = glm::cross(side, direction);
        const float t = static_cast<float>(i) / static_cast<float>(rings - 1), r = radius(t);
        if (i > 0) along += glm::length(at(i) - at(i - 1));
        for (int s = 0; s <= sides; ++s) {
            const float turn = static_cast<float>(s) / static_cast<float>(sides),
                        a = glm::two_pi<float>() * turn;
            const glm::vec3 n = std::cos(a) * side + std::sin(a) * up;
            addVertex(mesh, at(i) + r * n, n, {turn * glm::two_pi<float>() * r, along});
        }
    }
    joinGrid(mesh, first, sides, static_cast<int>(rings) - 1);
    if (closed) return;
    const auto stride = static_cast<std::uint32_t>(sides) + 1;
    for (const bool end : {false, true}) {
        const std::uint32_t ring =
            first + (end ? static_cast<std::uint32_t>(rings - 1) * stride : 0);
        const glm::vec3 n =
            glm::normalize(end ? path[count - 1] - path[count - 2] : path[0] - path[1]);
        const std::uint32_t center = size(mesh);
        addVertex(mesh, end ? path[count - 1] : path[0], n, {});
        for (std::uint32_t s = 0; s < stride; ++s)
            addVertex(mesh, mesh.vertices[ring + s].position, n, {});
        for (std::uint32_t s = 1; s < stride; ++s) {
            for (const std::uint32_t i : end ? std::array{center, center + s + 1, center + s}
                                             : std::array{center, center + s, center + s + 1}) {
                mesh.indices.push_back(i);
            }
        }
    }
}

void transformFrom(MeshDraft& mesh, std::size_t first, const glm::mat4& m) {
    const glm::mat3 normal = glm::inverseTranspose(glm::mat3(m));
    for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
        Vertex& v = mesh.vertices[i];
        v.position = glm::vec3(m * glm::vec4(v.position, 1.0f));
        v.normal = glm::normalize(normal * v.normal);
    }
}

void shadeFrom(MeshDraft& mesh, std::size_t first,
               const std::function<float(const Vertex&)>& shade) {
    for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
        Vertex& v = mesh.vertices[i];
        const float s = glm::clamp(shade(v), 0.0f, 1.0f);
        v.color = glm::vec4(glm::vec3(v.color) * s, v.color.w);
    }
}

std::vector<glm::vec2> smooth(std::span<const glm::vec2> through, int steps) {
    return catmullRom(through, steps);
}
std::vector<glm::vec3> smooth(std::span<const glm::vec3> through, int steps) {
    return catmullRom(through, steps);
}

void addToScene(Scene& scene, MeshDraft mesh, const glm::dmat4& worldFromMesh) {
    const std::string name = mesh.name;
    const Index index = addMesh(scene, std::move(mesh));
    if (index != kNone) addInstance(scene, addNode(scene, name, worldFromMesh), index);
}

}  // namespace clerestory::shapes

// Noise from integer hashes only: the texels do not depend on the math library.
namespace clerestory::textures {

float hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    std::uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
    return static_cast<float>(h >> 8) / 16777216.0f;
}

float noise(float x, float y, int period, int octaves, std::uint32_t seed) {
    float sum = 0.0f, weight = 0.5f, total = 0.0f;
    for (int o = 0; o < octaves; ++o, period *= 2, weight *= 0.5f) {
        const float fx = x * static_cast<float>(period), fy = y * static_cast<float>(period);
        const float ix = std::floor(fx), iy = std::floor(fy);
        // Divisions take most of the time of a scene's textures; inside the period there are none.
        const auto wrap = [&](float v) {
            const int i = static_cast<int>(v);
            return static_cast<std::uint32_t>(
                i >= 0 && i < period ? i : (i % period + period) % period);
        };
        const auto after = [&](std::uint32_t i) {
            return i + 1 == static_cast<std::uint32_t>(period) ? 0u : i + 1;
        };
        const std::uint32_t x0 = wrap(ix), x1 = after(x0), y0 = wrap(iy), y1 = after(y0);
        const auto ease = [](float t) { return t * t * (3.0f - 2.0f * t); };
        const float tx = ease(fx - ix), ty = ease(fy - iy);
        const std::uint32_t s = seed + static_cast<std::uint32_t>(o);
        const float upper = glm::mix(hash(x0, y0, s), hash(x1, y0, s), tx);
        const float lower = glm::mix(hash(x0, y1, s), hash(x1, y1, s), tx);
        sum += weight * glm::mix(upper, lower, ty);
        total += weight;
    }
    return sum / total;
}

constexpr std::uint32_t kRowsForTwo = 32;  // more rows are divided between two threads

Index add(Scene& scene, std::string name, std::uint32_t width, std::uint32_t height,
          ColorSpace space, const std::function<glm::vec4(float u, float v)>& color) {
    TextureImage image{
        .name = std::move(name), .width = width, .height = height, .colorSpace = space};
    image.texels.resize(4ull * width * height);
    const auto fill = [&](std::uint32_t firstRow, std::uint32_t endRow) {
        std::uint8_t* texel = &image.texels[4ull * width * firstRow];
        for (std::uint32_t y = firstRow; y < endRow; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const glm::vec4 c =
                    color((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                          (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
                for (int i = 0; i < 4; ++i) {
                    const double level = 255.0f * glm::clamp(c[i], 0.0f, 1.0f);
                    *texel++ = static_cast<std::uint8_t>(level + 0.5);
                }
            }
        }
    };
    if (height < kRowsForTwo) {
        fill(0, height);
    } else {
        const std::jthread other(fill, 0, height / 2);
        fill(height / 2, height);
    }
    buildLevels(image);
    scene.images.push_back(std::move(image));
    scene.textures.push_back({.image = static_cast<Index>(scene.images.size() - 1)});
    return static_cast<Index>(scene.textures.size() - 1);
}

Index addConstant(Scene& scene, std::string name, float value) {
    return add(scene, std::move(name), 1, 1, ColorSpace::linear,
               [&](float, float) { return glm::vec4(glm::vec3(value), 1.0f); });
}

}  // namespace clerestory::textures
