// A frame is a tree of views: the root is the client's camera, and a mirror, a curved reflector or
// a piece of glass that a view sees may ask for a child view. This walks the tree and writes the
// passes, children first, and the reasons. Pure.
#pragma once

#include "plan/planner.h"
#include "plan/visibility/draws.h"
#include "plan/visibility/occlusion.h"

#include <map>
#include <tuple>

namespace clerestory {

// One view to plan, and where its picture goes.
struct ViewJob {
    DrawScene::Purpose purpose = DrawScene::Purpose::surface;
    std::string name = "surface";
    Effect effect = Effect::base;
    std::string reason;
    View view;
    std::uint32_t width = 0, height = 0;
    TargetId target = kNoTarget;
    std::uint32_t face = 0;
    std::uint32_t generation = 0;   // 0: the root
    double weight = 1.0;            // of the view in the frame; see kMinWeight
    bool captured = false;          // a probe's face, or what a mirror shows to one
    std::uint32_t mirrorsLeft = 0;  // mirrored views in mirrored views that may still be asked for
    std::uint32_t probeGeneration = 0;  // of the captured cubes that this view shows; 0: none
    std::vector<std::size_t> hidden;    // of Stage::surfaces, sorted
};

// Where a cube is captured from: the middle of its owner, which it does not show, or a probe that
// was placed in the scene.
struct CapturePoint {
    std::string name;
    glm::dvec3 center{0.0};  // world
    double radius = 0.0;     // of the owner; of a placed probe, half its size
    double znear = 0.0;
    std::optional<double> zfar;
    std::uint32_t resolution = 0;
    MapBlur blur;
    bool placed = false;
    Index id = 0;                     // the owner's instance, or the place in Scene::probes
    std::vector<std::size_t> hidden;  // of Stage::surfaces
};

class ViewTree {
public:
    // `stage` and what `context` refers to must outlive this; passes are appended to `plan`.
    ViewTree(FramePlan& plan, const Stage& stage, const FrameContext& context);

    // Appends what the view needs and the view itself. Returns what was seen from it.
    SeenView add(const ViewJob& job);

private:
    // Flat mirrors that lie in one plane and face the view share one picture.
    struct MirrorGroup;
    struct Snapshot;
    // placed, id, generation, blur
    using ProbeKey = std::tuple<bool, Index, std::uint32_t, std::uint32_t, double>;
    using MapKey = std::tuple<std::string, std::uint32_t, double>;  // name, blur

    TargetId environmentTarget();
    TargetId mapTarget(const EnvironmentMap& map,
                       const MapBlur& blur = {});  // prefiltered, resident
    // Appends the passes that blur `source`, a captured cube, or, without one, the stored `map`.
    // Returns the target that holds the result with all its levels.
    TargetId addBlur(const std::string& name, const MapBlur& blur, std::uint32_t faceSize,
                     std::uint32_t generation, TargetId source, const std::string& map = {});
    void serveFlat(const ViewJob& job, SeenView& seen, DrawScene& drawn);
    void serveGroup(const ViewJob& job, SeenView& seen, DrawScene& drawn, const MirrorGroup& group);
    // Share of what is around the middle of the box that is not sky; 0 in child views.
    double enclosedAt(const ViewJob& job, const Bounds& box);
    void serveCurved(const ViewJob& job, SeenView& seen, DrawScene& drawn);
    void serveRough(const ViewJob& job, SeenView& seen) const;
    void serveGlass(const ViewJob& job, SeenView& seen);
    TargetId addBackFaces(const ViewJob& job, std::vector<Draw>& glass, const std::string& layer);
    Bounds bodyOf(const ViewJob& job, const SeenSurface& seen) const;
    void addGlass(const ViewJob& job, const SeenView& seen, const DrawScene& behind,
                  std::span<const DrawLists::Behind> through);
    bool serveFromMap(const ViewJob& job, SeenSurface& seen, DrawScene& drawn);
    CapturePoint capturePointOf(const Surface& surface) const;
    double apartFromMiddle(const Surface& surface, const CapturePoint& point) const;
    TargetId probe(const CapturePoint& point, std::uint32_t generation);
    std::uint64_t circumstancesOf(const CapturePoint& point, std::uint32_t generation) const;

    TargetId addTarget(TargetSpec spec);
    // What is known of a surface when somebody has to serve it.
    struct Case {
        std::string name;
        Effect effect;
        double share = 0.0;   // of the view's picture
        double weight = 0.0;  // share of the view's light; see kMinWeight
        std::optional<Method> forced;
    };
    Method decide(const ViewJob& job, Case about, std::span<const Candidate> candidates);
    // What the job hides already, and what moves behind a wall of its view: a map stays true
    // whatever happens where nobody can see it.
    std::vector<std::size_t> hiddenFrom(const ViewJob& job) const;
    // True, and told, when nobody can see the surface behind a wall of the root view.
    bool hidden(const ViewJob& job, const std::string& name, Effect effect, const Bounds& box);
    void skip(const ViewJob& job, std::string name, Effect effect, std::string reason);

    FramePlan& plan_;
    const Stage& stage_;
    const EnvironmentMap& environment_;
    const EnvironmentMaps& maps_;
    std::map<MapKey, TargetId> mapTargets_;
    const ResidentMaps& resident_;
    const DeviceLimits& limits_;
    std::vector<Wall> walls_;  // of the root view
    std::vector<Bounds>
        opaqueBoxes_;          // of all clusters, relative to the root's eye; when asked for
    std::vector<bool> moves_;  // of each instance; empty when nothing does
    Bounds sceneBounds_;       // world, of any moment
    std::uint64_t sceneTriangles_;
    TargetId environmentTarget_ = kNoTarget;
    // Passes that make a map which is known by its own key, first and behind the last; ascending.
    std::vector<std::pair<std::size_t, std::size_t>> keyedPasses_;
    std::map<ProbeKey, TargetId> probes_;
};

// Below this, blur is narrower than a pixel of a common frame.
inline constexpr double kSharpRoughness = 0.02;

// The method that a request's word asks for; `own` is that of the words' own kind: a mirrored view,
// a captured cube, a backdrop. None where the choice is left to the planner.
template <class Word>
std::optional<Method> methodAsked(Word word, Method own) {
    switch (word) {
        case Word::automatic:
            return std::nullopt;
        case Word::environment:
            return Method::environment;
        case Word::traced:
            return Method::traced;
        default:
            return own;
    }
}

// What people call a surface: its node, its mesh, or its number.
std::string nameOf(const Scene& scene, const Surface& surface);

// Levels of a picture that is read blurred.
std::uint32_t pictureLevels(std::uint32_t width, std::uint32_t height);
// Levels of a prefiltered cube.
std::uint32_t roughnessLevels(std::uint32_t faceSize);

// What a surface reflects at the angle it is seen at, 0..1 (Schlick). toEye: from its middle, unit.
double reflectanceSeen(double reflectance, double cosine);

}  // namespace clerestory
