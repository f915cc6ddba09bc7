#include "room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace clerestory::bench {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
using Vector = std::array<float, 3>;

Vector sum(const Vector& a, float s, const Vector& b) {
    return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vector unit(const Vector& a) {
    const float length = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    return {a[0] / length, a[1] / length, a[2] / length};
}

struct Point {
    Vector position, normal;
};

enum RoomMaterial { floor, wall, chrome, glass, pane };

// The parts of a glTF file that grow with each mesh.
class Writer {
public:
    // surface(u, v): a point for u and v in 0..1, in columns x rows quadrilaterals.
    template <class Surface>
    void mesh(const std::string& name, RoomMaterial material, std::uint32_t columns,
              std::uint32_t rows, const Surface& surface) {
        std::vector<float> positions, normals;
        Vector low{1e9f, 1e9f, 1e9f}, high{-1e9f, -1e9f, -1e9f};
        for (std::uint32_t i = 0; i <= columns; ++i) {
            for (std::uint32_t j = 0; j <= rows; ++j) {
                const Point p = surface(float(i) / float(columns), float(j) / float(rows));
                positions.insert(positions.end(), p.position.begin(), p.position.end());
                normals.insert(normals.end(), p.normal.begin(), p.normal.end());
                for (int axis = 0; axis < 3; ++axis) {
                    low[axis] = std::min(low[axis], p.position[axis]);
                    high[axis] = std::max(high[axis], p.position[axis]);
                }
            }
        }
        // Front faces are on the side of the normals.
        const Vector middle = surface(0.5f, 0.5f).position;
        const Vector across = sum(surface(0.51f, 0.5f).position, -1.0f, middle);
        const Vector upward = sum(surface(0.5f, 0.51f).position, -1.0f, middle);
        const Vector turning = cross(across, upward), outward = surface(0.5f, 0.5f).normal;
        const bool flipped =
            turning[0] * outward[0] + turning[1] * outward[1] + turning[2] * outward[2] < 0.0f;
        std::vector<std::uint32_t> indices;
        for (std::uint32_t i = 0; i < columns; ++i) {
            for (std::uint32_t j = 0; j < rows; ++j) {
                const std::uint32_t a = i * (rows + 1) + j, b = a + rows + 1;
                const std::uint32_t next = flipped ? a + 1 : b, last = flipped ? b : a + 1;
                indices.insert(indices.end(), {a, next, b + 1, a, b + 1, last});
            }
        }
        std::ostringstream bounds;
        bounds << ",\"min\":[" << low[0] << ',' << low[1] << ',' << low[2] << "],\"max\":["
               << high[0] << ',' << high[1] << ',' << high[2] << ']';
        const int position = accessor(positions, 34962, 3, bounds.str());
        const int normal = accessor(normals, 34962, 3, "");
        const int index = accessor(indices, 34963, 1, "");
        std::ostringstream text;
        text << (count_ > 0 ? "," : "") << "{\"name\":\"" << name
             << "\",\"primitives\":[{\"attributes\":{\"POSITION\":" << position
             << ",\"NORMAL\":" << normal << "},\"indices\":" << index
             << ",\"material\":" << material << "}]}";
        meshes_ += text.str();
        nodes_ += (count_ > 0 ? ",{\"mesh\":" : "{\"mesh\":") + std::to_string(count_) + "}";
        ++count_;
    }

    int meshes() const { return count_; }
    std::string json(const std::string& moreNodes, const std::string& rest) const {
        return "{\"meshes\":[" + meshes_ + "],\"nodes\":[" + nodes_ + moreNodes +
               "],\"accessors\":[" + accessors_ + "],\"bufferViews\":[" + views_ +
               "],\"buffers\":[{\"uri\":\"room.bin\",\"byteLength\":" +
               std::to_string(bytes_.size()) + "}]," + rest + "}";
    }
    const std::string& bytes() const { return bytes_; }

private:
    template <class T>
    int accessor(const std::vector<T>& values, int target, std::size_t components,
                 const std::string& bounds) {
        const std::size_t size = values.size() * sizeof(T);
        const std::string comma = made_ > 0 ? "," : "";
        views_ += comma + "{\"buffer\":0,\"byteOffset\":" + std::to_string(bytes_.size()) +
                  ",\"byteLength\":" + std::to_string(size) +
                  ",\"target\":" + std::to_string(target) + "}";
        accessors_ += comma + "{\"bufferView\":" + std::to_string(made_) +
                      ",\"componentType\":" + (components == 1 ? "5125" : "5126") +
                      ",\"count\":" + std::to_string(values.size() / components) +
                      ",\"type\":" + (components == 1 ? "\"SCALAR\"" : "\"VEC3\"") + bounds + "}";
        bytes_.append(reinterpret_cast<const char*>(values.data()), size);
        return made_++;
    }

    std::string meshes_, nodes_, accessors_, views_, bytes_;
    int made_ = 0, count_ = 0;
};

auto plane(Vector corner, Vector along, Vector up) {
    return [=, normal = unit(cross(along, up))](float u, float v) {
        return Point{sum(sum(corner, u, along), v, up), normal};
    };
}

auto sphere(Vector center, float radius) {
    return [=](float u, float v) {
        const float turn = 2.0f * kPi * u, fall = kPi * v;
        const Vector n{std::sin(fall) * std::cos(turn), std::cos(fall),
                       -std::sin(fall) * std::sin(turn)};
        return Point{sum(center, radius, n), n};
    };
}

// A tube round the curve that winds twice round the axis while it winds three times round the ring.
Point knot(float u, float v) {
    const auto curve = [](float t) {
        const float r = 0.275f * (2.0f + std::cos(3.0f * t));
        return Vector{r * std::cos(2.0f * t), 1.2f + 0.275f * std::sin(3.0f * t),
                      r * std::sin(2.0f * t)};
    };
    const float t = 2.0f * kPi * u, turn = 2.0f * kPi * v;
    const Vector along = unit(sum(curve(t + 1e-2f), -1.0f, curve(t - 1e-2f)));
    const Vector side = unit(cross(along, {0.0f, 1.0f, 0.01f})), up = cross(side, along);
    Vector n{};
    n = sum(sum(n, std::cos(turn), up), std::sin(turn), side);
    return {sum(curve(t), 0.16f, n), n};
}

constexpr const char* kRest = R"("asset":{"version":"2.0"},"scene":0,
"scenes":[{"nodes":[NODES]}],
"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.05,"zfar":50}}],
"materials":[
{"name":"floor","pbrMetallicRoughness":{"baseColorFactor":[0.9,0.9,0.9,1],"roughnessFactor":0.02}},
{"name":"wall","pbrMetallicRoughness":{"baseColorFactor":[0.7,0.65,0.6,1],"metallicFactor":0,"roughnessFactor":0.8}},
{"name":"chrome","pbrMetallicRoughness":{"baseColorFactor":[0.95,0.95,0.95,1],"roughnessFactor":0.03}},
{"name":"glass","pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0},"extensions":{
"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_ior":{"ior":1.5},
"KHR_materials_volume":{"thicknessFactor":1}}},
{"name":"pane","doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":[0.95,1,0.97,1],"metallicFactor":0,
"roughnessFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}}],
"extensionsUsed":["KHR_lights_punctual","KHR_materials_transmission","KHR_materials_ior","KHR_materials_volume"],
"extensions":{"KHR_lights_punctual":{"lights":[
{"type":"point","color":[1,0.9,0.8],"intensity":60},{"type":"point","color":[0.8,0.9,1],"intensity":40},
{"type":"spot","intensity":80,"spot":{"innerConeAngle":0.3,"outerConeAngle":0.7}}]}})";

constexpr const char* kLightsAndCamera =
    R"(,{"translation":[-2,3.5,2],"extensions":{"KHR_lights_punctual":{"light":0}}}
,{"translation":[2.5,3.2,-1],"extensions":{"KHR_lights_punctual":{"light":1}}}
,{"translation":[0,3.8,1],"rotation":[-0.70710678,0,0,0.70710678],"extensions":{"KHR_lights_punctual":{"light":2}}}
,{"translation":[0,1.7,3.7],"camera":0})";

void write(const std::filesystem::path& file, const std::string& content) {
    std::ofstream out(file, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace

std::filesystem::path writeRoom(const std::filesystem::path& folder, const RoomSize& size) {
    const float edge = size.edge, half = 0.5f * edge, height = size.height;
    Writer out;
    out.mesh("floor", floor, 1, 1, plane({-half, 0, half}, {edge, 0, 0}, {0, 0, -edge}));
    out.mesh("ceiling", wall, 40, 40, plane({-half, height, -half}, {edge, 0, 0}, {0, 0, edge}));
    out.mesh("back", wall, 40, 40, plane({-half, 0, -half}, {edge, 0, 0}, {0, height, 0}));
    out.mesh("front", wall, 40, 40, plane({half, 0, half}, {-edge, 0, 0}, {0, height, 0}));
    out.mesh("left", wall, 40, 40, plane({-half, 0, half}, {0, 0, -edge}, {0, height, 0}));
    out.mesh("right", wall, 40, 40, plane({half, 0, -half}, {0, 0, edge}, {0, height, 0}));
    out.mesh("knot", chrome, 800, 96, knot);
    out.mesh("ball", glass, 128, 64, sphere({1.8f, 0.7f, 0.5f}, 0.6f));
    out.mesh("pane", pane, 1, 1, plane({-2.5f, 0.2f, 0.5f}, {1.2f, 0, 0.6f}, {0, 1.6f, 0}));
    out.mesh("left ball", wall, 64, 42, sphere({-2.0f, 0.4f, -2.0f}, 0.4f));
    out.mesh("right ball", wall, 64, 42, sphere({2.0f, 0.4f, -2.0f}, 0.4f));
    std::string nodes, rest = kRest;
    for (int i = 0; i < out.meshes() + 4; ++i) nodes += (i > 0 ? "," : "") + std::to_string(i);
    rest.replace(rest.find("NODES"), 5, nodes);
    const std::filesystem::path file = folder / "room.gltf";
    write(folder / "room.bin", out.bytes());
    write(file, out.json(kLightsAndCamera, rest));
    return file;
}

}  // namespace clerestory::bench
