// Lines and points: which pixels they cover, their colours, and that scenes without them are as
// they were.
#include "support.h"

#include <algorithm>
#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class LinesAndPoints : public GlTest {};

// World x of the centre of a column, and y of a row, in the plane z = 0 of request().
float columnAt(double pixel) {
    return static_cast<float>(2.0 * ((pixel + 0.5) / 32.0 - 1.0));
}
float rowAt(double pixel) {
    return -columnAt(pixel);
}

MeshDraft draftOf(Primitive primitive, const std::vector<glm::vec3>& positions, Index material) {
    MeshDraft draft{.name = "marks", .material = material, .primitive = primitive};
    for (const glm::vec3& p : positions) {
        draft.indices.push_back(static_cast<std::uint32_t>(draft.vertices.size()));
        draft.vertices.push_back({.position = p});
    }
    return draft;
}

FrameRequest requestOf(MeshDraft draft, Material material, const std::string& id) {
    Scene scene;
    draft.material = addMaterial(scene, std::move(material));
    place(scene, std::move(draft));
    return request(std::move(scene), id);
}

// Columns and rows of the pixels that are not black.
std::vector<glm::uvec2> covered(const Image& image) {
    std::vector<glm::uvec2> pixels;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            if (color(image, x, y) != glm::vec3(0.0f)) pixels.emplace_back(x, y);
        }
    }
    return pixels;
}

std::vector<glm::uvec2> block(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                              std::uint32_t height) {
    std::vector<glm::uvec2> pixels;
    for (std::uint32_t y = top; y < top + height; ++y) {
        for (std::uint32_t x = left; x < left + width; ++x) pixels.emplace_back(x, y);
    }
    return pixels;
}

Material red() {
    Material m;
    m.baseColor = {0.5f, 0.25f, 0.125f, 1.0f};
    return m;
}

bool draws(const FramePlan& plan, Primitive primitive) {
    for (const Pass& pass : plan.passes) {
        for (const std::span<const Draw> list : pass.drawLists()) {
            for (const Draw& draw : list) {
                if (draw.primitive == primitive) return true;
            }
        }
    }
    return false;
}

bool omits(const FramePlan& plan, Effect effect) {
    return std::any_of(plan.skipped.begin(), plan.skipped.end(), [&](const Skipped& skipped) {
        return skipped.name == "linesAndPoints" && skipped.effect == effect;
    });
}

MeshDraft triangleFar() {
    MeshDraft draft{.name = "triangle"};
    draft.vertices = {{.position = {5, 5, 0}}, {.position = {6, 5, 0}}, {.position = {5, 6, 0}}};
    draft.indices = {0, 1, 2};
    return draft;
}

}  // namespace

TEST_F(LinesAndPoints, APointCoversItsPixel) {
    const FrameRequest r =
        requestOf(draftOf(Primitive::points,
                          {{columnAt(10), rowAt(50), 0.0f}, {columnAt(41), rowAt(7), 0}}, 0),
                  red(), "points");
    const Image image = renderer().render(r).image;
    EXPECT_EQ(covered(image), (std::vector<glm::uvec2>{{41, 7}, {10, 50}}));
    EXPECT_EQ(color(image, 10, 50), glm::vec3(0.5f, 0.25f, 0.125f)) << "not lit";
}

TEST_F(LinesAndPoints, PointSizeIsTheEdgeOfASquareInPixels) {
    FrameRequest r = requestOf(draftOf(Primitive::points, {{columnAt(10), rowAt(50), 0.0f}}, 0),
                               red(), "wide point");
    for (const std::uint32_t size : {1u, 3u, 7u}) {
        r.pointSize = size;
        const std::uint32_t half = size / 2;
        EXPECT_EQ(covered(renderer().render(r).image), block(10 - half, 50 - half, size, size));
    }
    r.pointSize = 64.0;
    EXPECT_GT(covered(renderer().render(r).image).size(), 600u) << "cut off by the frame";
}

// From the centre of pixel 8 to that of pixel 40: OpenGL leaves out the last pixel of a line, so
// that strips cover none twice.
TEST_F(LinesAndPoints, ALineCoversTheRowOfItsEnds) {
    FrameRequest r = requestOf(
        draftOf(Primitive::lines, {{columnAt(8), rowAt(20), 0}, {columnAt(40), rowAt(20), 0}}, 0),
        red(), "row");
    EXPECT_EQ(covered(renderer().render(r).image), block(8, 20, 32, 1));
    r.pointSize = 5.0;
    EXPECT_EQ(covered(renderer().render(r).image), block(8, 18, 32, 5));
}

// The view of a scene that is a single point shows it in the middle.
TEST_F(LinesAndPoints, ASinglePointIsAScene) {
    FrameRequest r = requestOf(draftOf(Primitive::points, {{3, 2, 1}}, 0), red(), "a single point");
    r.camera = {};
    r.width = r.height = 65;
    EXPECT_EQ(covered(renderer().render(r).image), block(32, 32, 1, 1));
}

TEST_F(LinesAndPoints, ASlantedLineHasOnePixelInEveryColumn) {
    const FrameRequest r = requestOf(
        draftOf(Primitive::lines, {{columnAt(8), rowAt(50), 0}, {columnAt(40), rowAt(34), 0}}, 0),
        red(), "slanted");
    const auto pixels = covered(renderer().render(r).image);
    EXPECT_EQ(pixels.size(), 32u);
    for (const glm::uvec2& p : pixels) {
        EXPECT_NEAR(p.y, 50.0 - (p.x - 8.0) / 2.0, 0.51) << p.x;
    }
}

TEST_F(LinesAndPoints, ColoursAreThoseOfVerticesTimesTheMaterial) {
    MeshDraft line =
        draftOf(Primitive::lines, {{columnAt(8), rowAt(20), 0}, {columnAt(40), rowAt(20), 0}}, 0);
    line.vertices[0].color = {1, 0, 1, 1};
    line.vertices[1].color = {0, 1, 1, 1};
    Material m = red();
    m.emissive = {0.0f, 0.0f, 2.0f};
    FrameRequest r = requestOf(line, m, "gradient");
    const Image image = renderer().render(r).image;
    for (std::uint32_t x = 8; x < 40; ++x) {
        const float t = (static_cast<float>(x) - 8.0f) / 32.0f;
        const glm::vec3 expected(0.5f * (1.0f - t), 0.25f * t, 0.125f + 2.0f);
        EXPECT_NEAR(glm::length(color(image, x, 20) - expected), 0.0f, 2e-3f) << x;
    }
    r.effects.emission = false;
    EXPECT_NEAR(color(renderer().render(r).image, 24, 20).z, 0.125f, 1e-3f);
}

// Two ways to one picture: a quad with the same normal.
TEST_F(LinesAndPoints, AreLitIfTheyHaveNormals) {
    const Light sun{.kind = LightKind::directional, .intensity = {2, 3, 4}};
    const auto centre = [&](MeshDraft draft, const std::string& id) {
        Scene scene;
        Material m;
        m.baseColor = {0.8f, 0.6f, 0.4f, 1.0f};
        m.metallic = 0.0f;
        m.roughness = 0.6f;
        draft.material = addMaterial(scene, m);
        place(scene, std::move(draft));
        addLight(scene, sun, glm::dmat4(1.0));  // along -Z
        return centerColor(renderer().render(request(std::move(scene), id)).image);
    };
    const glm::vec3 surface = centre(quad(0.5f, 0), "lit quad");
    EXPECT_GT(surface.x, 0.2f);
    for (const Primitive primitive : {Primitive::points, Primitive::lines}) {
        std::vector<glm::vec3> positions{{columnAt(32), rowAt(32), 0.0f}};
        if (primitive == Primitive::lines) positions.emplace_back(columnAt(40), rowAt(32), 0.0f);
        MeshDraft draft = draftOf(primitive, positions, 0);
        EXPECT_EQ(centre(draft, "unlit marks"), glm::vec3(0.8f, 0.6f, 0.4f));
        draft.hasNormals = true;  // (0, 0, 1)
        EXPECT_NEAR(glm::length(centre(draft, "lit marks") - surface), 0.0f, 5e-3f);
        for (Vertex& v : draft.vertices) v.normal = {0, 0, -1};
        EXPECT_LT(glm::length(centre(draft, "marks from behind")), 0.01f);
    }
}

TEST_F(LinesAndPoints, AreHiddenByWhatIsNearer) {
    for (const double z : {-0.5, 0.5}) {
        Scene scene;
        place(scene, quad(3.0f, addMaterial(scene, unlit({0, 0, 1, 1}))));
        place(scene, draftOf(Primitive::points, {{0.01f, 0.01f, 0.0f}}, addMaterial(scene, red())),
              moved(0, 0, z));
        const Image image = renderer().render(request(std::move(scene), "behind")).image;
        EXPECT_EQ(color(image, 32, 31).x > 0.0f, z > 0.0) << z;
    }
}

// A mirror in the plane z = 0 shows a point at z = 1 where it would be at z = -1; a pane before it
// shows the point itself.
TEST_F(LinesAndPoints, AreSeenInMirrorsAndThroughGlass) {
    Scene scene;
    place(scene, quad(1.5f, addMaterial(scene, mirrorMetal())));
    place(scene, draftOf(Primitive::points, {{0.8f, 0.5f, 1.0f}}, addMaterial(scene, red())));
    FrameRequest r = request(std::move(scene), "mirrored point");
    r.accuracy.planar = PlanarMethod::mirror;
    const auto pixel = [](double x, double y, double distance) {
        return glm::uvec2(32.0 * (1.0 + x / distance), 32.0 * (1.0 - y / distance));
    };
    Frame frame = renderer().render(r);
    const glm::uvec2 direct = pixel(0.8, 0.5, 1.0), mirrored = pixel(0.8, 0.5, 3.0);
    EXPECT_EQ(color(frame.image, direct.x, direct.y), glm::vec3(0.5f, 0.25f, 0.125f));
    EXPECT_GT(color(frame.image, mirrored.x, mirrored.y).x, 0.1f);
    EXPECT_FALSE(omits(frame.plan, Effect::base));
    r.accuracy.planar = PlanarMethod::traced;
    frame = renderer().render(r);
    EXPECT_EQ(color(frame.image, mirrored.x, mirrored.y), glm::vec3(0.0f));
    EXPECT_TRUE(omits(frame.plan, Effect::base));

    Scene glazed;
    place(glazed, quad(1.5f, addMaterial(glazed, clearGlass())), moved(0, 0, 0.5));
    place(glazed, draftOf(Primitive::points, {{0.01f, 0.01f, 0.0f}}, addMaterial(glazed, red())));
    r = request(std::move(glazed), "point behind glass");
    r.accuracy.glass = GlassMethod::backdrop;
    EXPECT_GT(color(renderer().render(r).image, 32, 31).x, 0.4f);
}

TEST_F(LinesAndPoints, CastNoShadowsAndThePlanSaysSo) {
    Scene scene;
    const Index white = addMaterial(scene, Material{.metallic = 0.0f});
    place(scene, quad(1.0f, white));
    place(scene, quad(0.05f, white), moved(-0.9, -0.9, 0.2));  // so that something has a shadow
    place(scene, draftOf(Primitive::lines, {{-1, 0.5f, 0.5f}, {1, 0.5f, 0.5f}},
                         addMaterial(scene, red())));
    const Light sun{.kind = LightKind::directional, .intensity = {2, 3, 4}};
    addLight(scene, sun, glm::dmat4(1.0));
    FrameRequest r = request(std::move(scene), "line before a wall");
    const Image without = renderer().render(r).image;
    r.effects.shadows = true;
    r.pointSize = 1.0;
    const Frame frame = renderer().render(r);
    EXPECT_EQ(centerColor(frame.image), centerColor(without));
    EXPECT_TRUE(omits(frame.plan, Effect::shadows));
    for (const Pass& pass : frame.plan.passes) {
        if (const auto* shadow = std::get_if<DrawShadow>(&pass.work)) {
            EXPECT_EQ(shadow->draws.size(), 2u);
            for (const Draw& draw : shadow->draws) EXPECT_EQ(draw.primitive, Primitive::triangles);
        }
    }
}

TEST_F(LinesAndPoints, AreCountedAsDraws) {
    Scene scene;
    const Index m = addMaterial(scene, red());
    place(scene, draftOf(Primitive::points, {{0, 0, 0}, {0.5f, 0, 0}}, m));
    place(scene, draftOf(Primitive::lines, {{0, 0, 0}, {0.5f, 0, 0}}, m));
    place(scene, quad(0.3f, m));
    const FrameRequest r = request(std::move(scene), "counted marks");
    const RendererCounters before = renderer().counters();
    const PlanTotals planned = totals(renderer().render(r).plan);
    const RendererCounters after = renderer().counters();
    EXPECT_EQ(planned.draws, 3u);
    EXPECT_EQ(planned.triangles, 2u);
    EXPECT_EQ(after.drawCalls - before.drawCalls, planned.draws);
    EXPECT_EQ(after.triangles - before.triangles, planned.triangles);
}

// A captured cube is captured again for another size only if it shows lines or points.
TEST_F(LinesAndPoints, PointSizeChangesNothingWithoutThem) {
    for (const bool marked : {false, true}) {
        Scene scene;
        place(scene, sphere(0.5f, 16, addMaterial(scene, mirrorMetal())));
        place(scene, quad(1.0f, addMaterial(scene, unlit({1, 0.5f, 0.25f, 1}))), moved(0, 0, -1));
        if (marked) {
            place(scene, draftOf(Primitive::points, {{1.5f, 0.5f, 0}, {1.5f, -0.5f, 0}},
                                 addMaterial(scene, unlit({0, 0, 1, 1}))));
        }
        FrameRequest r = request(std::move(scene), marked ? "ball and points" : "ball");
        r.accuracy.curved = CurvedMethod::probe;
        r.accuracy.probeSize = 32;
        renderer().render(r);
        const Frame one = renderer().render(r);
        r.pointSize = 9.0;
        const Frame nine = renderer().render(r);
        EXPECT_EQ(one.image.data == nine.image.data, !marked);
        EXPECT_EQ(one.plan.passes.size() == nine.plan.passes.size(), !marked);
        EXPECT_EQ(draws(nine.plan, Primitive::points), marked);
    }
}

TEST_F(LinesAndPoints, ChannelsShowThem) {
    FrameRequest r = requestOf(draftOf(Primitive::points, {{columnAt(10), rowAt(50), 0.0f}}, 0),
                               red(), "channels of a point");
    r.output.channel = Channel::depth;
    EXPECT_NEAR(number(renderer().render(r).image, 10, 50), 2.0f, 1e-5f);
    r.output.channel = Channel::objectId;
    EXPECT_EQ(number(renderer().render(r).image, 10, 50), 1.0f);
}

// The meshes that light between surfaces refines keep their lines, wherever these begin.
TEST_F(LinesAndPoints, StayWhereLightIsComputed) {
    Scene scene;
    const Index m = addMaterial(scene, red());
    place(scene, draftOf(Primitive::points, {{columnAt(10), rowAt(50), 0.0f}}, m));
    place(scene, draftOf(Primitive::lines,
                         {{columnAt(8), rowAt(20), 0}, {columnAt(40), rowAt(20), 0}}, m));
    MeshDraft lit = draftOf(Primitive::points, {{columnAt(50), rowAt(10), 0.0f}}, m);
    lit.hasNormals = true;
    place(scene, lit);
    MeshDraft far = triangleFar();
    far.material = m;
    place(scene, far);
    place(scene, far, moved(0, 0, -1));  // so that surfaces hide light from each other
    FrameRequest r = request(std::move(scene), "marks with light");
    r.environment.map = "white";
    r.environment.visible = false;
    const Image without = renderer().render(r).image;
    r.effects.indirectLight = true;
    const LightState light = renderer().completeLight(r);
    EXPECT_TRUE(light.complete) << light.failure;
    const Image with = renderer().render(r).image;
    EXPECT_EQ(covered(with), covered(without));
    EXPECT_EQ(covered(with).size(), 34u);
    EXPECT_NEAR(glm::length(color(with, 50, 10) - color(without, 50, 10)), 0.0f, 0.05f)
        << "in the open";
}
