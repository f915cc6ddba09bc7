// One list of fields is used for writing and for reading, so that the two always agree.
//
// Layout: header, payload, checksum of both (XXH3). An array of plain values is a count and the
// bytes in memory; a text or a list of structures is a count and the parts.
#include "scene/import/cache/blob.h"

#include "scene/hash.h"
#include "scene/import/base/types.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>

namespace clerestory {
namespace {

struct Header {
    char magic[8] = {'C', 'L', 'S', 'C', 'E', 'N', 'E', '\0'};
    std::uint32_t version = 15;
    std::uint32_t vertexBytes = sizeof(Vertex);
};

template <class T>
constexpr bool kFlat =
    std::is_arithmetic_v<T> || std::is_same_v<T, Vertex> || std::is_same_v<T, Cluster> ||
    std::is_same_v<T, Instance> || std::is_same_v<T, BaseVertex> || std::is_same_v<T, Influence> ||
    std::is_same_v<T, MorphDelta> || std::is_same_v<T, Variant::Choice>;
template <class T>
struct FlatVector : std::false_type {};
template <class T, glm::qualifier Q, int N>
struct FlatVector<glm::vec<N, T, Q>> : std::true_type {};

template <class A>
void serialize(A& a, glm::dquat& q) {
    a(q.x), a(q.y), a(q.z), a(q.w);
}
template <class A>
void serialize(A& a, glm::dmat4& m) {
    for (int column = 0; column < 4; ++column) a(m[column]);
}
template <class A>
void serialize(A& a, TextureImage& i) {
    a(i.name), a(i.width), a(i.height), a(i.levels), a(i.hasAlpha), a(i.packedNormal), a(i.mean),
        a(i.leastGreen), a(i.slope);
    a(i.texels);
    a(i.colorSpace, ColorSpace::srgb);
}
template <class A>
void serialize(A& a, Texture& t) {
    a(t.image), a(t.useLevels);
    a(t.wrapU, Wrap::clampToEdge), a(t.wrapV, Wrap::clampToEdge);
    a(t.magnify, Filter::linear), a(t.minify, Filter::linear);
}
// Structures with a field table of their own.
template <class A, class T>
void serializeTable(A& a, T& value) {
    fields(value, [&](const char*, auto& member, const auto& kind, const auto&...) {
        if constexpr (requires { kind.last; })
            a(member, kind.last);
        else
            a(member);
    });
}
template <class A>
void serialize(A& a, TextureSlot& s) {
    serializeTable(a, s);
}
template <class A>
void serialize(A& a, MapBlur& b) {
    serializeTable(a, b);
}
template <class A>
void serialize(A& a, Material& m) {
    serializeTable(a, m);
}
template <class A>
void serialize(A& a, Bounds& b) {
    a(b.min), a(b.max);
}
template <class A>
void serialize(A& a, FlatPart& p) {
    a(p.firstCluster), a(p.clusterCount), a(p.normal), a(p.offset), a(p.area), a(p.bounds);
}
template <class A>
void serialize(A& a, Mesh& m) {
    a(m.name), a(m.firstCluster), a(m.clusterCount), a(m.firstFlatPart), a(m.flatPartCount);
    a(m.primitive, Primitive::triangles), a(m.lit), a(m.primitives);
    a(m.area), a(m.material), a(m.bounds);
    a(m.hasColors), a(m.deformation);
}
template <class A>
void serialize(A& a, Node& n) {
    a(n.name), a(n.parent), a(n.parentFromLocal), a(n.visible);
}
template <class A>
void serialize(A& a, Light& l) {
    a(l.name), a(l.node), a(l.kind, LightKind::directional), a(l.intensity), a(l.range);
    a(l.innerConeAngle), a(l.outerConeAngle), a(l.radius);
}
template <class A>
void serialize(A& a, Camera& c) {
    a(c.name), a(c.node), a(c.orthographic), a(c.yfov), a(c.yHalfHeight), a(c.znear), a(c.zfar);
}
template <class A>
void serialize(A& a, Probe& p) {
    a(p.name), a(p.node), a(p.position), a(p.size), a(p.resolution), a(p.zfar), a(p.blur);
}
template <class A>
void serialize(A& a, Track& c) {
    a(c.property, AnimatedProperty::camera), a(c.target),
        a(c.interpolation, Interpolation::cubicSpline);
    a(c.times), a(c.values), a(c.field);
}
template <class A>
void serialize(A& a, Clip& c) {
    a(c.name), a(c.duration), a(c.tracks);
}
template <class A>
void serialize(A& a, MovingNode& n) {
    a(n.node), a(n.rest.translation), a(n.rest.rotation), a(n.rest.scale);
}
template <class A>
void serialize(A& a, MorphWeights& w) {
    a(w.node), a(w.rest);
}
template <class A>
void serialize(A& a, AnimatedLight& l) {
    a(l.light), serializeTable(a, l.rest);
}
template <class A>
void serialize(A& a, Skin& s) {
    a(s.joints), a(s.jointFromMesh);
}
template <class A>
void serialize(A& a, Deformation& d) {
    a(d.mesh), a(d.firstVertex), a(d.base), a(d.skin), a(d.weights), a(d.perVertex);
    a(d.influences), a(d.firstDelta), a(d.deltas), a(d.flatNormals);
}
template <class A>
void serialize(A& a, DefaultView& v) {
    a(v.position), a(v.target), a(v.yfov), a(v.fit);
}
template <class A>
void serialize(A& a, Variant& v) {
    a(v.name), a(v.choices);
}
template <class A>
void serialize(A& a, ImportWarning& w) {
    a(w.code), a(w.subject), a(w.message), a(w.count);
}
template <class A>
void serialize(A& a, Scene& s) {
    a(s.id), a(s.title), a(s.scenesOfFile), a(s.sceneOfFile), a(s.contentHash), a(s.vertices),
        a(s.indices), a(s.clusters), a(s.flatParts);
    a(s.meshes), a(s.materials), a(s.variants), a(s.images), a(s.textures), a(s.nodes),
        a(s.instances);
    a(s.lights), a(s.cameras), a(s.probes), a(s.clips), a(s.movingNodes), a(s.morphWeights);
    a(s.animatedLights), a(s.skins), a(s.deformations), a(s.reach), a(s.motionReach),
        a(s.defaultView), a(s.environment);
    a(s.environmentRotation), a(s.warnings);
}

struct EnvironmentHeader {
    char magic[8] = {'C', 'L', 'E', 'N', 'V', 'M', 'A', 'P'};
    std::uint32_t version = 1;
    std::uint32_t faceSize = 0;
};

class Writer {
public:
    explicit Writer(const BlobSink& sink) : sink_(sink) {}

    void bytes(const void* from, std::size_t count) {
        hash_.addBytes(from, count);
        sink_(from, count);
    }
    std::uint64_t checksum() const { return hash_.value(); }

    template <class T>
    void operator()(T& value) {
        if constexpr (std::is_same_v<T, bool>) {
            const std::uint8_t byte = value ? 1 : 0;
            bytes(&byte, 1);
        } else if constexpr (kFlat<T> || FlatVector<T>::value) {
            bytes(&value, sizeof value);
        } else {
            serialize(*this, value);
        }
    }
    template <class E>
    void operator()(E& value, E) {
        bytes(&value, sizeof value);
    }
    void operator()(std::string& text) {
        length(text.size());
        bytes(text.data(), text.size());
    }
    template <class T>
    void operator()(std::optional<T>& value) {
        bool present = value.has_value();
        (*this)(present);
        if (present) (*this)(*value);
    }
    template <class T>
    void operator()(std::vector<T>& list) {
        length(list.size());
        if constexpr (kFlat<T>) {
            bytes(list.data(), list.size() * sizeof(T));
        } else {
            for (T& item : list) (*this)(item);
        }
    }

private:
    void length(std::uint64_t count) { bytes(&count, sizeof count); }

    const BlobSink& sink_;
    ContentHash hash_;
};

// Everything is hashed and copied in pieces that the processor's caches hold.
class Reader {
public:
    Reader(const BlobSource& source, std::uint64_t left) : source_(source), left_(left) {}

    void bytes(void* to, std::size_t count) {
        if (count > left_) throw BlobError("the scene blob is truncated");
        if (count == 0) return;
        source_(to, count);
        hash_.addBytes(to, count);
        left_ -= count;
    }
    std::uint64_t left() const { return left_; }
    std::uint64_t checksum() const { return hash_.value(); }

    template <class T>
    void operator()(T& value) {
        if constexpr (std::is_same_v<T, bool>) {
            std::uint8_t byte = 0;
            bytes(&byte, 1);
            value = byte != 0;
        } else if constexpr (kFlat<T> || FlatVector<T>::value) {
            bytes(&value, sizeof value);
        } else {
            serialize(*this, value);
        }
    }
    template <class E>
    void operator()(E& value, E last) {
        std::underlying_type_t<E> number = 0;
        bytes(&number, sizeof number);
        if (number > static_cast<std::underlying_type_t<E>>(last)) {
            throw BlobError("the scene blob has an unknown enumerator");
        }
        value = static_cast<E>(number);
    }
    void operator()(std::string& text) {
        text.resize(length(1));
        bytes(text.data(), text.size());
    }
    template <class T>
    void operator()(std::optional<T>& value) {
        bool present = false;
        (*this)(present);
        if (present) (*this)(value.emplace());
    }
    template <class T>
    void operator()(std::vector<T>& list) {
        if constexpr (kFlat<T>) {
            const std::size_t count = length(sizeof(T));
            // The driver uses vertices and indices in place if it may read a little beyond their
            // end; see gl::kSharedMemoryTail. Texels are copied.
            constexpr std::size_t kTail = sizeof(T) == 1 ? 0 : 64;
            list.reserve(count + (kTail + sizeof(T) - 1) / sizeof(T));
            append(list, count);
        } else {
            const std::size_t count = length(1);
            for (std::size_t i = 0; i < count; ++i) (*this)(list.emplace_back());
        }
    }

private:
    // Without filling the list with zeros first.
    template <class T>
    void append(std::vector<T>& list, std::size_t count) {
        constexpr std::size_t kAtOnce =
            std::max(std::size_t{1}, (std::size_t{1} << 17) / sizeof(T));
        while (count > 0) {
            const std::size_t part = std::min(count, kAtOnce);
            piece_.resize(std::max(piece_.size(), part * sizeof(T)));
            bytes(piece_.data(), part * sizeof(T));
            const auto* items = reinterpret_cast<const T*>(piece_.data());
            list.insert(list.end(), items, items + part);
            count -= part;
        }
    }
    // A count of items of at least itemBytes each, so that memory is bounded by the blob's size.
    std::size_t length(std::size_t itemBytes) {
        std::uint64_t count = 0;
        bytes(&count, sizeof count);
        if (count > left_ / itemBytes) throw BlobError("the scene blob is truncated");
        return static_cast<std::size_t>(count);
    }

    const BlobSource& source_;
    std::uint64_t left_;
    ContentHash hash_;
    std::vector<std::byte> piece_;
};

}  // namespace

void writeScene(const Scene& scene, const BlobSink& sink) {
    Writer writer(sink);
    const Header header;
    writer.bytes(&header, sizeof header);
    serialize(
        writer,
        const_cast<Scene&>(scene));  // the list is shared with reading; writing does not modify it
    const std::uint64_t checksum = writer.checksum();
    sink(&checksum, sizeof checksum);
}

Scene readScene(const BlobSource& source, std::uint64_t size) {
    const Header expected;
    Header header;
    std::uint64_t checksum = 0;
    if (size < sizeof header + sizeof checksum) throw BlobError("the scene blob is truncated");
    Reader reader(source, size - sizeof checksum);
    reader.bytes(&header, sizeof header);
    if (std::memcmp(&header, &expected, sizeof header) != 0) {
        throw BlobError("not a scene blob of this version");
    }
    Scene scene;
    serialize(reader, scene);
    if (reader.left() > 0) throw BlobError("the scene blob is longer than its scene");
    source(&checksum, sizeof checksum);
    if (reader.checksum() != checksum) throw BlobError("the scene blob's checksum is wrong");
    updateContentHash(scene);
    return scene;
}

Scene readScene(std::span<const std::byte> blob) {
    const std::byte* next = blob.data();
    return readScene(
        [&](void* to, std::size_t count) {
            std::memcpy(to, next, count);
            next += count;
        },
        blob.size());
}

void writeEnvironment(const EnvironmentMap& map, const BlobSink& sink) {
    EnvironmentHeader header;
    header.faceSize = map.faceSize;
    sink(&header, sizeof header);
    sink(map.texels.data(), map.texels.size() * sizeof(glm::vec3));
}

EnvironmentMap readEnvironment(std::span<const std::byte> blob) {
    EnvironmentHeader header, expected;
    if (blob.size() < sizeof header) throw BlobError("the environment map is truncated");
    std::memcpy(&header, blob.data(), sizeof header);
    expected.faceSize = header.faceSize;
    if (std::memcmp(&header, &expected, sizeof header) != 0 || header.faceSize == 0 ||
        header.faceSize > kMaxImportedFace) {
        throw BlobError("not an environment map of this version");
    }
    EnvironmentMap map;
    map.faceSize = header.faceSize;
    const std::size_t texels = std::size_t{6} * map.faceSize * map.faceSize;
    if (blob.size() != sizeof header + texels * sizeof(glm::vec3)) {
        throw BlobError("the environment map has a wrong number of texels");
    }
    map.texels.resize(texels);
    std::memcpy(map.texels.data(), blob.data() + sizeof header, texels * sizeof(glm::vec3));
    for (const glm::vec3& t : map.texels) {
        for (int c = 0; c < 3; ++c) {
            if (!(t[c] >= 0.0f && t[c] <= 65504.0f)) {
                throw BlobError("the environment map has invalid texels");
            }
        }
    }
    completeMap(map);
    return map;
}

}  // namespace clerestory
