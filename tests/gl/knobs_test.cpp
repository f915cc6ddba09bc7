// Accuracy knobs compared with geometry in double precision: each step is closer to the truth than
// the previous one.
#include "room.h"
#include "sight.h"

#include <glm/gtc/matrix_transform.hpp>

#include <map>

namespace clerestory::test {
namespace {

class Knobs : public GlTest {};

Material silver() {
    Material m = mirrorMetal();
    m.reflection = Reflection::mirror;
    return m;
}

struct Against {
    double wrong = 0.0;      // share of the compared pixels that show something else
    double misplaced = 0.0;  // pixels between the middles of the panel's image and of its true one
    int compared = 0;
};

// A ball in a room behind a free-standing emissive panel, which no proxy box represents.
struct PanelRoom {
    static constexpr double kRadius = 0.5, kPanel = 0.6, kPanelZ = 0.4;
    glm::dvec3 center{0.3, -0.2, -0.6};
    glm::vec3 glow{5.0f, 5.0f, 0.0f};

    Scene scene() const {
        Scene s;
        Room{}.build(s);
        place(s, quad(float(kPanel), addMaterial(s, glowing(glow))), moved(0.9, 0.2, kPanelZ));
        place(s, sphere(float(kRadius), 96, addMaterial(s, silver())),
              glm::translate(glm::dmat4(1.0), center));
        return s;
    }
    // The hit of a ray inside the room; `margin`: distance from an edge between two colours.
    glm::vec3 radianceAlong(const Ray& ray, double& margin) const {
        const glm::vec3 wall =
            Room{}.radianceAt(leavesBox(ray, glm::dvec3(-kRoom), glm::dvec3(kRoom)), margin);
        const double t = (kPanelZ - ray.origin.z) / ray.direction.z;
        if (!(t > 0.0)) return wall;
        const glm::dvec3 p = ray.origin + t * ray.direction - glm::dvec3(0.9, 0.2, kPanelZ);
        const double beyond = std::max(std::abs(p.x), std::abs(p.y)) - kPanel;
        margin = std::min(margin, std::abs(beyond));
        if (beyond < 0.0) margin = -beyond;
        return beyond < 0.0 ? glow : wall;
    }
    Against compare(const FrameRequest& r) const {
        const Image image = renderer().render(r).image;
        Against result;
        int wrong = 0;
        glm::dvec3 seen(0.0), expected(0.0);  // sums of pixels' places and their number
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const auto t = meetsBall(ray, center, kRadius);
                if (!t || !meetsBall(ray, center, 0.95 * kRadius)) continue;
                const glm::dvec3 p = ray.origin + *t * ray.direction;
                double margin = 0.0;
                const glm::vec3 truth =
                    radianceAlong({p, glm::reflect(ray.direction, (p - center) / kRadius)}, margin);
                const glm::vec3 is = color(image, x, y);
                if (is.x > 2.5f) seen += glm::dvec3(x, y, 1);
                if (truth.x > 2.5f) expected += glm::dvec3(x, y, 1);
                if (margin < 0.05) continue;
                ++result.compared;
                wrong += greatestDifference(is, truth) > 0.02;
            }
        }
        EXPECT_GT(expected.z, 50.0);
        EXPECT_GT(seen.z, 0.0);
        result.wrong = double(wrong) / std::max(result.compared, 1);
        result.misplaced = glm::distance(glm::dvec2(seen) / std::max(seen.z, 1.0),
                                         glm::dvec2(expected) / std::max(expected.z, 1.0));
        return result;
    }
};

FrameRequest ofTheBall(const PanelRoom& gallery, const std::string& id) {
    FrameRequest r = request(gallery.scene(), id, {-1.2, 0.9, 2.7});
    r.camera.target = gallery.center;
    r.camera.yfov = 0.4;
    r.width = r.height = 160;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.probeSize = 512;
    return r;
}

// C2. A direction alone puts everything at infinity, a box puts it on the walls, the cube's own
// distances put it where it stands.
TEST_F(Knobs, DepthParallaxPlacesObjectsInTheRoom) {
    const PanelRoom gallery;
    FrameRequest r = ofTheBall(gallery, "parallax");
    std::map<Parallax, Against> by;
    for (const Parallax p : {Parallax::none, Parallax::box, Parallax::depth}) {
        r.accuracy.parallax = p;
        by[p] = gallery.compare(r);
    }
    const Against none = by[Parallax::none], box = by[Parallax::box], depth = by[Parallax::depth];
    EXPECT_GT(none.compared, 3000);
    EXPECT_LT(box.wrong, 0.5 * none.wrong);
    EXPECT_LT(box.misplaced, none.misplaced);
    EXPECT_LT(depth.wrong, 0.5 * box.wrong);
    EXPECT_LT(depth.misplaced, 0.7 * box.misplaced);
}

// C4.
TEST_F(Knobs, LargerCubesShowEdgesMoreExactly) {
    const PanelRoom gallery;
    FrameRequest r = ofTheBall(gallery, "sizes");
    r.accuracy.parallax = Parallax::depth;
    double before = 1.0;
    for (const std::uint32_t size : {16u, 32u, 64u, 128u, 256u, 512u}) {
        r.accuracy.probeSize = size;
        const double wrong = gallery.compare(r).wrong;
        EXPECT_LT(wrong, before) << size;
        before = wrong;
    }
    EXPECT_LT(before, 0.01);
}

// ---- back faces --------------------------------------------------------------------------------

// A block of glass with six sides, as one body. Its back leans: it lies at z = -half.z + lean x.
MeshDraft wedge(const glm::vec3& half, float lean, Index material) {
    MeshDraft draft{.name = "wedge", .material = material, .hasNormals = true};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            const auto first = static_cast<std::uint32_t>(draft.vertices.size());
            for (const glm::vec2 corner :
                 {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
                Vertex v;
                v.normal = glm::vec3(0.0f);
                v.normal[axis] = float(side);
                v.position[axis] = half[axis] * float(side);
                v.position[(axis + 1) % 3] = half[(axis + 1) % 3] * corner.x * float(side);
                v.position[(axis + 2) % 3] = half[(axis + 2) % 3] * corner.y;
                if (v.position.z < 0.0f) v.position.z += lean * v.position.x;
                if (axis == 2 && side < 0) v.normal = glm::normalize(glm::vec3(lean, 0.0f, -1.0f));
                draft.vertices.push_back(v);
            }
            for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) {
                draft.indices.push_back(first + i);
            }
        }
    }
    return draft;
}

// Vertical stripes in the plane z = -2, 0.4 metres wide.
constexpr double kStripes = -2.0, kStripe = 0.4;
glm::vec3 stripeAt(double x, double& margin) {
    const double k = std::floor(x / kStripe);
    margin = std::min(x - k * kStripe, (k + 1) * kStripe - x);
    return std::fmod(std::abs(k), 2.0) == 0.0 ? glm::vec3(0.2f, 0.9f, 0.3f)
                                              : glm::vec3(0.9f, 0.2f, 0.3f);
}

// Share of the pixels within a thick wedge's front face, and leaving by its back face, that show
// another stripe than Snell's law says at both. Neither a ball nor a wall has such a back.
TEST_F(Knobs, BackFacesMakeWedgesRefractBySnell) {
    const double lean = 0.2;
    const glm::dvec3 half(0.8, 0.8, 0.25);
    const double ior = 1.5;
    const glm::dmat4 worldFromWedge =
        glm::rotate(glm::dmat4(1.0), glm::radians(30.0), glm::dvec3(0, 1, 0));
    Scene scene;
    for (int k = -20; k < 20; ++k) {
        double ignored = 0.0;
        const glm::vec3 radiance = stripeAt((k + 0.5) * kStripe, ignored);
        place(scene, quad(0.5f * float(kStripe), addMaterial(scene, glowing(radiance))),
              glm::scale(moved((k + 0.5) * kStripe, 0, kStripes), glm::dvec3(1, 20, 1)));
    }
    Material glass{.name = "glass", .metallic = 0.0f, .roughness = 0.0f, .transmission = 1.0f};
    glass.thickness = 0.5f;
    place(scene, wedge(half, float(lean), addMaterial(scene, glass)), worldFromWedge);
    FrameRequest r = request(std::move(scene), "wedge", {0.1, 0.05, 3.0});
    r.camera.yfov = 0.6;
    r.width = r.height = 160;
    r.accuracy.glass = GlassMethod::backdrop;

    const glm::dmat4 wedgeFromWorld = glm::inverse(worldFromWedge);
    const double f0 = std::pow((ior - 1) / (ior + 1), 2.0);
    const auto wrong = [&](bool backFaces) {
        r.accuracy.backFaces = backFaces;
        const Image image = renderer().render(r).image;
        int compared = 0, off = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const glm::dvec3 from(wedgeFromWorld * glm::dvec4(ray.origin, 1.0));
                const glm::dvec3 d(wedgeFromWorld * glm::dvec4(ray.direction, 0.0));
                const glm::dvec3 in = from + (half.z - from.z) / d.z * d;
                const glm::dvec3 bent(d.x / ior, d.y / ior,
                                      -std::sqrt(1.0 - (d.x * d.x + d.y * d.y) / (ior * ior)));
                const double way = (-half.z - in.z + lean * in.x) / (bent.z - lean * bent.x);
                const glm::dvec3 out = in + way * bent;
                const glm::dvec3 leaving(
                    worldFromWedge *
                    glm::dvec4(glm::refract(bent, glm::normalize(glm::dvec3(-lean, 0, 1)), ior),
                               0.0));
                const double inside = 0.97;
                if (std::abs(in.x) > inside * half.x || std::abs(in.y) > inside * half.y ||
                    std::abs(out.x) > inside * half.x || std::abs(out.y) > inside * half.y) {
                    continue;
                }
                const glm::dvec3 exit(worldFromWedge * glm::dvec4(out, 1.0));
                const glm::dvec3 met = exit + (kStripes - exit.z) / leaving.z * leaving;
                // Beyond the picture's edge a body shows the environment.
                const glm::dvec2 slope =
                    glm::abs(glm::dvec2(met) - glm::dvec2(ray.origin)) / (ray.origin.z - kStripes);
                if (std::max(slope.x, slope.y) > 0.95 * std::tan(0.3)) continue;
                double margin = 0.0;
                const glm::vec3 expected = stripeAt(met.x, margin);
                if (margin < 0.04) continue;
                ++compared;
                // Between the two stripes' colours lies 0.7; what is lost at the faces is known.
                off += greatestDifference(color(image, x, y),
                                          expected * float((1 - f0) / (1 + f0))) > 0.1;
            }
        }
        EXPECT_GT(compared, 2000);
        return double(off) / compared;
    };
    const double proxy = wrong(false), exact = wrong(true);
    EXPECT_LT(exact, 0.01);
    EXPECT_GT(proxy, 0.2) << "a ball's or a wall's back is not a wedge's";
}

}  // namespace
}  // namespace clerestory::test
