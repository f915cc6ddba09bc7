#include "plan/effects/glass_layers.h"

#include "plan/effects/method_choice.h"
#include "plan/visibility/view.h"
#include "plan/visibility/visibility.h"

#include <algorithm>
#include <map>

namespace clerestory {
namespace {

// Of glass behind glass in a view; nearer glass shares the last one.
constexpr std::size_t kMaxGlassLayers = 4;

// Whether two boxes have more than this share of the smaller one in common, 0..1.
bool overlap(const ScreenBox& a, const ScreenBox& b, double share) {
    if (!a.overlaps(b)) return false;
    const ScreenBox common{glm::max(a.low, b.low), glm::min(a.high, b.high)};
    return common.share() > share * std::min(a.share(), b.share());
}

struct PlacedLayer : GlassLayer {
    std::vector<ScreenBox> boxes;  // of its glass
    ScreenBox whole;               // around all that it draws

    // Whether a part of the box may lie in front of what the layer draws.
    bool isBehind(const ScreenBox& box, double leastShared) const {
        if (!box.overlaps(whole)) return false;
        return !blendedDraws.empty() || boxes.size() > kMaxBoxes ||
               std::any_of(boxes.begin(), boxes.end(), [&](const ScreenBox& other) {
                   return overlap(box, other, leastShared);
               });
    }
    void add(const ScreenBox& box) {
        if (box.empty()) return;
        whole = whole.empty()
                    ? box
                    : ScreenBox{glm::min(whole.low, box.low), glm::max(whole.high, box.high)};
    }
    static constexpr std::size_t kMaxBoxes = 256;  // beyond it, the whole decides
};

// Layers of glass, far to near. What is added lies in front of what was added before where both
// overlap, by more than the given share of the smaller box.
class Placement {
public:
    Placement(std::size_t most, double leastShared) : most_(most), leastShared_(leastShared) {}

    // The layer that glass joins: the one after the last that it covers a part of.
    std::size_t addGlass(const ScreenBox& box, bool rough) {
        const std::size_t wanted = inFrontOf(box), at = std::min(wanted, most_ - 1);
        enough_ &= at == wanted;
        if (at == layers_.size()) layers_.emplace_back();
        layers_[at].boxes.push_back(box);
        layers_[at].add(box);
        layers_[at].rough |= rough;
        return at;
    }
    void addDraw(std::size_t layer, const Draw& draw) { layers_[layer].glassDraws.push_back(draw); }

    // Blended draws follow the glass of their layer. There is glass already.
    void addBlended(const ScreenBox& box, const Draw& draw) {
        const std::size_t front = inFrontOf(box);
        PlacedLayer& layer = layers_[front == 0 ? 0 : front - 1];
        layer.blendedDraws.push_back(draw);
        layer.add(box);
    }

    bool enough() const { return enough_; }  // each glass has a layer of its own
    std::vector<GlassLayer> layers() const { return {layers_.begin(), layers_.end()}; }

private:
    std::size_t inFrontOf(const ScreenBox& box) const {
        std::size_t layer = layers_.size();
        while (layer > 0 && !layers_[layer - 1].isBehind(box, leastShared_)) --layer;
        return layer;
    }

    std::size_t most_;
    double leastShared_;
    bool enough_ = true;
    std::vector<PlacedLayer> layers_;
};

Draw facing(Draw draw, DrawnFaces faces) {
    draw.faces = faces;
    return draw;
}

// Glass joins a layer in front of the other glass that it overlaps. Clear panes are ordered by
// cluster, because all windows of a car are one mesh and one is visible through another; shells by
// their faces: what is within is between their far and their near wall.
Placement placed(const ViewTask& task, const SeenView& seen,
                 std::span<const DrawLists::Behind> through, double leastShared, bool bothWalls) {
    const std::size_t most = task.generation == 0 ? kMaxGlassLayers : 1;
    Placement layers(most, leastShared);
    std::map<std::size_t, std::size_t> layerOf, nearest;  // by index of SeenView::surfaces
    std::map<Index, std::size_t> layerOfBody;  // by instance: one layer for all sides of a body
    for (std::size_t i = 0; i < through.size(); ++i) nearest[through[i].seen] = i;
    std::map<std::size_t, std::vector<Draw>> nearWalls;
    for (std::size_t i = 0; i < through.size(); ++i) {
        const DrawLists::Behind& item = through[i];
        if (!item.glass) {
            layers.addBlended(screenBox(task.view, item.box), item.draw);
            continue;
        }
        const Surface& surface = *seen.surfaces[item.seen].surface;
        const ScreenBox whole = screenBox(task.view, seen.surfaces[item.seen].box);
        const bool rough = surface.roughness > kSharpRoughness;
        if (surface.shell && bothWalls) {
            if (!layerOf.contains(item.seen)) layerOf[item.seen] = layers.addGlass(whole, rough);
            layers.addDraw(layerOf[item.seen], facing(item.draw, DrawnFaces::back));
            nearWalls[item.seen].push_back(facing(item.draw, DrawnFaces::front));
            if (nearest[item.seen] != i) continue;
            const std::size_t near = layers.addGlass(whole, rough);
            for (const Draw& draw : nearWalls[item.seen]) layers.addDraw(near, draw);
            continue;
        }
        if (surface.glass == Glass::solid && layerOfBody.contains(surface.instance)) {
            layerOf[item.seen] = layerOfBody[surface.instance];
        }
        // Rough panes are not ordered by cluster: their blur would include their neighbours.
        const bool apart = surface.glass == Glass::pane && !rough;
        if (apart || !layerOf.contains(item.seen)) {
            const ScreenBox box = apart ? screenBox(task.view, item.box) : whole;
            layerOf[item.seen] = layerOfBody[surface.instance] = layers.addGlass(box, rough);
        }
        layers.addDraw(layerOf[item.seen], item.draw);
    }
    return layers;
}

// Boxes are larger than what is in them, those of a turned ball by 60 %. If the layers do not
// suffice, glass that overlaps by less than this shares one: where it does overlap, the nearest
// glass hides the other.
constexpr double kSmallOverlap = 0.25;

}  // namespace

std::vector<GlassLayer> glassLayers(const ViewTask& task, const SeenView& seen,
                                    std::span<const DrawLists::Behind> through) {
    // A captured cube has one layer.
    if (task.generation > 0) return placed(task, seen, through, 0.0, false).layers();
    Placement placement = placed(task, seen, through, 0.0, true);
    if (!placement.enough()) placement = placed(task, seen, through, kSmallOverlap, true);
    // The order of bodies matters more than the far walls of each.
    if (!placement.enough()) placement = placed(task, seen, through, 0.0, false);
    return placement.layers();
}

}  // namespace clerestory
