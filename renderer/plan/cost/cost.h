// What each way of serving a reflector or a piece of glass takes and gets wrong, and which one to
// take: as a database plans a query.
//
// Milliseconds are those of one reference machine (two cores, Mesa 22.3 llvmpipe) or of a small
// GPU: their ratios decide, and a decision must not depend on how busy a machine is, nor on what
// happens to be resident: the same request gives the same bytes. Errors are relative RMSE on the
// pixels of the effect (accuracy.md, section 1).
#pragma once

#include "plan/graph/decision.h"
#include "plan/request/frame_request.h"

#include <span>

namespace clerestory {

// What a way would have to do.
struct Work {
    double triangles = 0.0;  // drawn in child views
    double pixels = 0.0;     // shaded in child views
    double views = 0.0;
    double copiedPixels = 0.0;  // copied, not shaded
    double rayPixels = 0.0;     // pixels of the parent view that follow rays
    double rays = 0.0;          // for each of them
    double frames = 1.0;        // frames that share the work
    bool software = true;
};
double milliseconds(const Work& work);

// The cheapest candidate whose error is at most `tolerance` (relative, on the surface's pixels);
// where none is that good, the one with the least error. Ties go to the first. candidates is not
// empty.
std::size_t cheapest(std::span<const Candidate> candidates, double tolerance);

// What a surface weighs is its share of the frame's light, about: what it reflects or lets through
// (0..1, at the angle it is seen at) times its share of the frame. Lighter ones are not worth a
// view or a ray, even when the request asks for it.
inline constexpr double kMinWeight = 4e-4;

// Error that a preset accepts of a surface: relative error times weight.
double toleranceOf(Preset preset);

// Relative RMSE of a curved mirror's pixels, by roughness: the environment map alone, a captured
// cube, rays through the mesh. enclosed: share of its surroundings that is not sky; see
// enclosure.h. apart: how far the mirror reaches from the cube's centre, in radii of the scene.
double environmentError(double roughness, double enclosed = 0.0);
double probeError(double roughness, double apart = 0.0);
double tracedError(double roughness);
// The same of a flat mirror's own picture.
double mirrorError(double roughness);

// Relative RMSE of the pixels of glass: against the environment map, against a copy of what was
// drawn behind it. solid: a body, not a pane; backFaces: its far side is drawn.
double glassEnvironmentError();
double backdropError(bool solid, bool backFaces);
// Segments of a ray through a piece of glass, as counted in Work::rays.
double glassRaySegments(bool solid, std::uint32_t bounces);

// Number of frames over which the cost of a captured cube is spread. It does not depend on what is
// resident: otherwise one request could give two pictures.
double framesPerCapture(bool sceneMoves);

// Weight of a captured face in its frame. It does not depend on the view that shows its owner.
inline constexpr double kCaptureWeight = 0.03;

// Layers of opaque surface above which drawing depth first pays (measured on the software
// rasteriser: Sponza 198 -> 127 ms at some five layers; nothing gained at one).
inline constexpr double kPrepassOverdraw = 1.2;
// Share of the picture that a cluster's box must cover for each of its triangles to be drawn depth
// first; 23 pixels of 1280x720. Finer ones hide less than drawing them twice costs (Sponza's court:
// 217 -> 207 ms of processor time, between a quarter and four times this share the same).
inline constexpr double kOccluderShare = 2.5e-5;

}  // namespace clerestory
