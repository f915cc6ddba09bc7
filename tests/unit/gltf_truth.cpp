// A slow and simple implementation of the glTF 2.0 specification.
#include "gltf_truth.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace clerestory::test {
namespace {

std::string bytesOf(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string fromBase64(const std::string& text) {
    const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    unsigned bits = 0, have = 0;
    for (const char c : text) {
        const auto digit = alphabet.find(c);
        if (digit == std::string::npos) break;
        bits = bits << 6 | static_cast<unsigned>(digit);
        have += 6;
        if (have >= 8) {
            have -= 8;
            out += static_cast<char>(bits >> have & 0xff);
        }
    }
    return out;
}

TruthMatrix identity() {
    TruthMatrix m{};
    for (std::size_t i = 0; i < 4; ++i) m[i][i] = 1.0;
    return m;
}

TruthMatrix product(const TruthMatrix& a, const TruthMatrix& b) {
    TruthMatrix m{};
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            for (std::size_t k = 0; k < 4; ++k) m[i][j] += a[i][k] * b[k][j];
        }
    }
    return m;
}

TruthPoint moved(const TruthMatrix& m, const TruthPoint& p) {
    TruthPoint out{};
    for (std::size_t i = 0; i < 3; ++i) {
        out[i] = m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3];
    }
    return out;
}

// Of a unit quaternion x y z w, from v' = v + 2 w (u x v) + 2 u x (u x v).
TruthMatrix turned(const std::vector<double>& q) {
    TruthMatrix m = identity();
    const TruthPoint u{q[0], q[1], q[2]};
    const auto cross = [](const TruthPoint& a, const TruthPoint& b) {
        return TruthPoint{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                          a[0] * b[1] - a[1] * b[0]};
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        TruthPoint v{};
        v[axis] = 1.0;
        const TruthPoint once = cross(u, v), twice = cross(u, once);
        for (std::size_t i = 0; i < 3; ++i) m[i][axis] = v[i] + 2 * q[3] * once[i] + 2 * twice[i];
    }
    return m;
}

void toUnit(std::vector<double>& q) {
    double square = 0.0;
    for (const double v : q) square += v * v;
    for (double& v : q) v /= std::sqrt(square);
}

double twiceArea(const TruthTriangle& t) {
    TruthPoint a{}, b{};
    for (std::size_t i = 0; i < 3; ++i) {
        a[i] = t[1][i] - t[0][i];
        b[i] = t[2][i] - t[0][i];
    }
    return std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                      a[0] * b[1] - a[1] * b[0]);
}

}  // namespace

GltfTruth::GltfTruth(const std::filesystem::path& file) {
    const std::string content = bytesOf(file);
    std::string binary;
    if (content.starts_with("glTF")) {
        std::uint32_t jsonLength = 0, binaryLength = 0;
        std::memcpy(&jsonLength, content.data() + 12, 4);
        json_ = Json::parse(content.substr(20, jsonLength));
        if (content.size() > 28 + jsonLength) {
            std::memcpy(&binaryLength, content.data() + 20 + jsonLength, 4);
            binary = content.substr(28 + jsonLength, binaryLength);
        }
    } else {
        json_ = Json::parse(content);
    }
    for (const Json& buffer : json_["buffers"]) {
        const std::string uri = buffer.value("uri", "");
        const auto comma = uri.find(',');
        buffers_.push_back(uri.empty()                ? binary
                           : uri.starts_with("data:") ? fromBase64(uri.substr(comma + 1))
                                                      : bytesOf(file.parent_path() / uri));
    }
}

std::string GltfTruth::clipName(std::size_t clip) const {
    return json_["animations"][clip].value("name", "");
}

double GltfTruth::duration(std::size_t clip) const {
    double last = 0.0;
    for (const Json& sampler : json_["animations"][clip]["samplers"]) {
        for (const auto& time : accessor(sampler["input"])) last = std::max(last, time[0]);
    }
    return last;
}

std::vector<std::vector<double>> GltfTruth::accessor(std::size_t number) const {
    const Json& a = json_["accessors"][number];
    const std::map<std::string, std::size_t> widths{
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    const std::size_t width = widths.at(a["type"]);
    const int type = a["componentType"];
    const std::size_t size = type == 5126 || type == 5125   ? 4
                             : type == 5122 || type == 5123 ? 2
                                                            : 1;
    const Json& view = json_["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::string& bytes = buffers_.at(view["buffer"]);
    const std::size_t stride = view.value("byteStride", width * size);
    const std::size_t start =
        view.value("byteOffset", std::size_t{0}) + a.value("byteOffset", std::size_t{0});
    const bool shares = a.value("normalized", false);
    std::vector<std::vector<double>> rows;
    for (std::size_t i = 0; i < a["count"].get<std::size_t>(); ++i) {
        std::vector<double> row;
        for (std::size_t k = 0; k < width; ++k) {
            const char* at = bytes.data() + start + i * stride + k * size;
            const auto as = [&]<class T>(T value) {
                std::memcpy(&value, at, sizeof value);
                return static_cast<double>(value);
            };
            double v = type == 5126   ? as(float{})
                       : type == 5125 ? as(std::uint32_t{})
                       : type == 5123 ? as(std::uint16_t{})
                       : type == 5122 ? as(std::int16_t{})
                       : type == 5121 ? as(std::uint8_t{})
                                      : as(std::int8_t{});
            if (shares) {
                v = type == 5123   ? v / 65535.0
                    : type == 5121 ? v / 255.0
                    : type == 5122 ? std::max(v / 32767.0, -1.0)
                                   : std::max(v / 127.0, -1.0);
            }
            row.push_back(v);
        }
        rows.push_back(row);
    }
    return rows;
}

std::vector<double> GltfTruth::valueAt(const Json&, const Json& sampler, bool turns,
                                       double time) const {
    const auto times = accessor(sampler["input"]);
    const auto output = accessor(sampler["output"]);
    const std::string how = sampler.value("interpolation", "LINEAR");
    const std::size_t parts = how == "CUBICSPLINE" ? 3 : 1;
    // Weights are stored as one scalar per target for each key.
    const std::size_t rows = output.size() / (parts * times.size());
    const auto part = [&](std::size_t key, std::size_t which) {
        std::vector<double> all;
        for (std::size_t r = 0; r < rows; ++r) {
            const auto& row = output[(key * parts + which) * rows + r];
            all.insert(all.end(), row.begin(), row.end());
        }
        return all;
    };
    const std::size_t middle = parts == 3 ? 1 : 0;
    std::vector<double> result;
    if (time <= times.front()[0]) {
        result = part(0, middle);
    } else if (time >= times.back()[0]) {
        result = part(times.size() - 1, middle);
    } else {
        std::size_t k = 0;
        while (times[k + 1][0] <= time) ++k;
        const double step = times[k + 1][0] - times[k][0];
        const double s = (time - times[k][0]) / step;
        auto a = part(k, middle), b = part(k + 1, middle);
        if (how == "LINEAR" && turns) {  // some files round theirs to three digits
            toUnit(a);
            toUnit(b);
        }
        result = a;
        if (how == "LINEAR" && turns) {
            double dot = 0.0;
            for (std::size_t i = 0; i < 4; ++i) dot += a[i] * b[i];
            const double sign = dot < 0.0 ? -1.0 : 1.0;
            const double angle = std::acos(std::min(1.0, std::abs(dot)));
            for (std::size_t i = 0; i < 4; ++i) {
                result[i] =
                    angle < 1e-6
                        ? a[i] + s * (sign * b[i] - a[i])
                        : (std::sin((1 - s) * angle) * a[i] + std::sin(s * angle) * sign * b[i]) /
                              std::sin(angle);
            }
        } else if (how == "LINEAR") {
            for (std::size_t i = 0; i < a.size(); ++i) result[i] = a[i] * (1 - s) + b[i] * s;
        } else if (how == "CUBICSPLINE") {
            // As a Bezier curve, by de Casteljau.
            const auto leaving = part(k, 2), coming = part(k + 1, 0);
            for (std::size_t i = 0; i < a.size(); ++i) {
                double p[4] = {a[i], a[i] + leaving[i] * step / 3, b[i] - coming[i] * step / 3,
                               b[i]};
                for (int level = 3; level > 0; --level) {
                    for (int j = 0; j < level; ++j) p[j] = p[j] * (1 - s) + p[j + 1] * s;
                }
                result[i] = p[0];
            }
        }
    }
    if (turns) toUnit(result);
    return result;
}

void GltfTruth::pose(std::size_t clip, double time) {
    moved_.clear();
    const Json& animation = json_["animations"][clip];
    for (const Json& channel : animation["channels"]) {
        const Json& target = channel["target"];
        if (!target.contains("node")) continue;
        const std::string path = target["path"];
        moved_[target["node"]][path] =
            valueAt(animation, animation["samplers"][channel["sampler"].get<std::size_t>()],
                    path == "rotation", time);
    }
    order_.clear();
    world_.clear();
    for (const Json& root : json_["scenes"][json_.value("scene", 0)]["nodes"]) {
        place(root, identity());
    }
}

void GltfTruth::place(std::size_t node, const TruthMatrix& parent) {
    const Json& json = json_["nodes"][node];
    TruthMatrix local = identity();
    if (json.contains("matrix")) {
        for (std::size_t i = 0; i < 16; ++i) local[i % 4][i / 4] = json["matrix"][i];
    } else {
        const auto part = [&](const char* path, std::vector<double> otherwise) {
            const auto& moved = moved_[node];
            if (const auto at = moved.find(path); at != moved.end()) return at->second;
            return json.value(path, otherwise);
        };
        const auto t = part("translation", {0, 0, 0}), s = part("scale", {1, 1, 1});
        auto q = part("rotation", {0, 0, 0, 1});
        toUnit(q);
        local = turned(q);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) local[i][k] *= s[k];
            local[i][3] = t[i];
        }
    }
    order_.push_back(node);
    world_[node] = product(parent, local);
    const TruthMatrix here = world_[node];
    if (!json.contains("children")) return;
    for (const Json& child : json["children"]) place(child, here);
}

std::vector<TruthTriangle> GltfTruth::triangles() const {
    std::vector<TruthTriangle> all;
    for (const std::size_t node : order_) addTriangles(node, all);
    return all;
}

void GltfTruth::addTriangles(std::size_t node, std::vector<TruthTriangle>& out) const {
    const Json& json = json_["nodes"][node];
    if (!json.contains("mesh")) return;
    const Json& mesh = json_["meshes"][json["mesh"].get<std::size_t>()];
    for (const Json& primitive : mesh["primitives"]) {
        if (primitive.value("mode", 4) != 4) continue;
        const Json& attributes = primitive["attributes"];
        const auto base = accessor(attributes["POSITION"]);
        auto points = base;
        if (primitive.contains("targets")) {
            std::vector<double> weights =
                json.value("weights", mesh.value("weights", std::vector<double>{}));
            if (const auto at = moved_.find(node); at != moved_.end()) {
                const auto set = at->second.find("weights");
                if (set != at->second.end()) weights = set->second;
            }
            for (std::size_t t = 0; t < weights.size(); ++t) {
                const auto deltas = accessor(primitive["targets"][t]["POSITION"]);
                for (std::size_t i = 0; i < points.size(); ++i) {
                    for (std::size_t k = 0; k < 3; ++k) points[i][k] += weights[t] * deltas[i][k];
                }
            }
        }
        std::vector<TruthPoint> placed;
        std::vector<TruthMatrix> jointMatrices;
        std::vector<std::vector<double>> joints, shares;
        if (json.contains("skin")) {
            const Json& skin = json_["skins"][json["skin"].get<std::size_t>()];
            const auto binds = skin.contains("inverseBindMatrices")
                                   ? accessor(skin["inverseBindMatrices"])
                                   : std::vector<std::vector<double>>{};
            for (std::size_t j = 0; j < skin["joints"].size(); ++j) {
                TruthMatrix bind = identity();
                for (std::size_t i = 0; i < 16 && !binds.empty(); ++i) {
                    bind[i % 4][i / 4] = binds[j][i];
                }
                jointMatrices.push_back(product(world_.at(skin["joints"][j]), bind));
            }
            joints = accessor(attributes["JOINTS_0"]);
            shares = accessor(attributes["WEIGHTS_0"]);
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            const TruthPoint p{points[i][0], points[i][1], points[i][2]};
            if (jointMatrices.empty()) {
                placed.push_back(moved(world_.at(node), p));
                continue;
            }
            TruthPoint sum{};
            double all = 0.0;
            for (std::size_t k = 0; k < 4; ++k) {
                const auto q = moved(jointMatrices.at(static_cast<std::size_t>(joints[i][k])), p);
                for (std::size_t c = 0; c < 3; ++c) sum[c] += shares[i][k] * q[c];
                all += shares[i][k];
            }
            for (double& c : sum) c /= all;
            placed.push_back(sum);
        }
        std::vector<std::size_t> corners;
        if (primitive.contains("indices")) {
            for (const auto& row : accessor(primitive["indices"])) {
                corners.push_back(static_cast<std::size_t>(row[0]));
            }
        } else {
            for (std::size_t i = 0; i < placed.size(); ++i) corners.push_back(i);
        }
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
            TruthTriangle triangle, inFile;
            for (std::size_t k = 0; k < 3; ++k) {
                triangle[k] = placed[corners[i + k]];
                const auto& p = base[corners[i + k]];
                inFile[k] = {p[0], p[1], p[2]};
            }
            if (twiceArea(inFile) > 0.0) out.push_back(triangle);
        }
    }
}

}  // namespace clerestory::test
