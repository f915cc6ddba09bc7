// Cost model: predicted time and error of each method for a reflector or a piece of glass, and the
// choice between methods. All constants of the model are here and in cost.cpp.
//
// Milliseconds are those of a reference machine (two cores, llvmpipe) or graphics card. Only their
// ratios matter. Predictions depend neither on the load of the machine nor on resident maps, so
// that equal requests give equal bytes. Errors are relative RMSE over the pixels of the effect
// (docs/accuracy.md).
#pragma once

#include "plan/graph/decision.h"
#include "plan/request/frame_request.h"

#include <span>

namespace clerestory {

// Prices of work, milliseconds. `scripts/bench prices` measures most of them alone, and all of them
// together in whole scenes.
struct Prices {
    double view;               // per child view
    double cube;               // per captured cube, apart from its views and map samples
    double draw;               // per surface drawn in child views
    double triangle;           // per triangle drawn
    double triangleLight;      // per triangle whose vertices have light between surfaces
    double pixel;              // per pixel shaded, without lights and textures
    double pixelLight;         // per pixel and light that reaches it
    double pixelShadow;        // per pixel and such light with a shadow map
    double pixelSurfaceLight;  // per pixel that shows light between surfaces
    double pixelTexture;       // per pixel and texture
    double copiedPixel;        // per pixel copied without shading
    double mapSample;          // per direction and texel of a prefiltered cube
    double rayPass;            // per view that traces rays
    double raySurface;         // per surface that traces rays
    double rayPixel;           // per pixel with a ray
    double rayLight;           // per such pixel and light that reaches what its ray hits
    double rayTexture;         // per such pixel and texture of what its ray hits
    double raySegment;         // per such pixel and further segment of its ray
};
// Of a driver, software or not; processorRays: rays are followed on the processor.
const Prices& pricesOf(bool software, bool processorRays);

// What shading a point of a scene takes, on average.
struct Shading {
    double lights = 0.0;        // that reach it
    double textures = 0.0;      // of its material
    double glass = 0.0;         // fraction of the surfaces that are glass, 0..1
    bool shadows = false;       // lights have shadow maps
    bool surfaceLight = false;  // it shows light between surfaces
};

// The work that a method adds to a frame.
struct Work {
    double draws = 0.0;         // surfaces drawn in child views
    double triangles = 0.0;     // drawn in child views
    double pixels = 0.0;        // shaded in child views
    double views = 0.0;         // child views
    double cubes = 0.0;         // captured cubes
    double copiedPixels = 0.0;  // copied without shading
    double mapSamples = 0.0;    // texels of a prefiltered cube times directions per texel
    double rayPixels = 0.0;     // pixels of the parent view that trace rays
    double rays = 0.0;          // ray segments per such pixel
    double paths = 1.0;         // that share such a ray; see pathsOfRay()
    double density = 1.0;       // see rayDensity()
    double hits = 1.0;          // fraction of the rays that meet a surface, 0..1
    double sharing = 1.0;       // surfaces that share the copied pixels or the pass of the rays
    double lookups = 0.0;       // of shadows in pixels of the parent view
    double frames = 1.0;        // frames that share the drawn work
    Shading shading;
    bool software = true;
    bool processorRays = false;  // the rays are followed on the processor
};
double milliseconds(const Work& work);

// Errors of methods that differ by less than this factor are about equal.
inline constexpr double kSameError = 1.1;

// Returns the index of the cheapest candidate whose error is at most `tolerance` (relative RMSE
// over the pixels of the surface); if there is none, of the cheapest whose error is about the
// smallest: at most kSameError times as large. The first wins a tie. `candidates` must not be
// empty.
std::size_t cheapest(std::span<const Candidate> candidates, double tolerance);

// The weight of a surface estimates its fraction of the light of the frame: reflectance or
// transmittance at the viewing angle (0..1) times covered fraction of the frame. Below this weight
// a surface gets neither a view nor rays, even if the request names the method.
inline constexpr double kMinWeight = 4e-4;

// Error of a surface that a preset accepts: relative RMSE times weight.
double toleranceOf(Preset preset);

// The error that a preset accepts of a surface of this weight, as relative RMSE. `draft` accepts
// more of a picture that resembles the truth.
double acceptedError(Preset preset, double weight);

// Relative RMSE of the pixels of a curved mirror of this roughness (0..1) with the environment map
// only, with a captured cube, with rays. enclosed: fraction of the directions around it that
// geometry blocks, 0..1; see enclosure.h. apart: distance of the surface from the cube's centre,
// 0..1; see apartFromCenter().
double environmentError(double roughness, double enclosed = 0.0);
double probeError(double roughness, double apart = 0.0);
// paths: that share a ray.
double tracedError(double roughness, double paths = 1.0);
// The same of a flat mirror with a mirrored view. slope: root mean square of the slopes of its
// bumps, for whose directions the picture was not drawn.
double mirrorError(double roughness, double slope = 0.0);

// Relative RMSE of the frame if a light has no shadow, and if it has a shadow map, whose edges are
// one texel wide. share: root mean square of the light's fraction of the irradiance, 0..1.
double unshadowedError(double share);
double shadowMapError(double share);

// Relative RMSE of the pixels of glass over the environment map, and over a copy of the picture
// behind it. enclosed: as environmentError(); solid: a body, not a pane; backFaces: exit points
// come from its back faces.
double glassEnvironmentError(double enclosed = 0.0);
double backdropError(bool solid, bool backFaces);
// The same of a pane without a mirrored view, which reflects the environment map.
double unmirroredPaneError(double enclosed);
// Paths that share a ray of a surface of this roughness: raySamples, if it is rough and the
// processor follows the rays.
double pathsOfRay(std::uint32_t raySamples, double roughness, bool processorRays);
// Rays per pixel of a flat mirror, for Work::rays: on the processor most of its pixels, whose rays
// are nearly parallel, take the mean of neighbours.
double flatRays(bool processorRays);
// Rays relative to those of `standard`: pixels between two rays whose results agree have the mean
// of both.
double rayDensity(Preset preset, bool processorRays);
// Number of segments of a ray through a piece of glass, for Work::rays; panes have two faces, too.
double glassRaySegments(std::uint32_t bounces);

// Number of frames that share the cost of a captured cube. It does not depend on resident maps:
// otherwise one request could give two different pictures.
double framesPerCapture(bool sceneMoves);

// Weight of a face of a captured cube. It does not depend on the view that shows the cube.
inline constexpr double kCaptureWeight = 0.03;

// Layers of opaque surfaces above which a depth prepass saves time (software rasteriser: Sponza,
// five layers, 198 -> 127 ms; no gain with one layer).
inline constexpr double kPrepassOverdraw = 1.2;
// Fraction of the picture that the box of a cluster must cover, per triangle, for the depth prepass
// to include it; 23 pixels of 1280x720. Smaller triangles cost more to draw twice than they save
// (Sponza's court: 217 -> 207 ms of processor time; the same from a quarter to four times this).
inline constexpr double kOccluderShare = 2.5e-5;

}  // namespace clerestory
