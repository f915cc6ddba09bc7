// What a draw's shader variant can do, one bit each; compiled as GLSL and as C++.
// The program is compiled with a constant FEATURES, so unused features are not compiled.

const uint FEATURE_BASE_COLOR_MAP = 1u << 0;
const uint FEATURE_METALLIC_ROUGHNESS_MAP = 1u << 1;
const uint FEATURE_NORMAL_MAP = 1u << 2;
const uint FEATURE_OCCLUSION_MAP = 1u << 3;
const uint FEATURE_EMISSION = 1u << 4;      // the material's emitted radiance is added
const uint FEATURE_EMISSIVE_MAP = 1u << 5;
const uint FEATURE_VERTEX_COLOR = 1u << 6;
const uint FEATURE_TEXTURE_TRANSFORM = 1u << 7;
const uint FEATURE_SECOND_TEXCOORD = 1u << 8;
const uint FEATURE_MASK = 1u << 9;          // alphaMode mask: discard below alphaCutoff
const uint FEATURE_BLEND = 1u << 10;        // alphaMode blend: write coverage
const uint FEATURE_DOUBLE_SIDED = 1u << 11;
const uint FEATURE_UNLIT = 1u << 12;
const uint FEATURE_LIGHTS = 1u << 13;       // the draw has a list of lights
const uint FEATURE_DEFAULT_NUMBERS = 1u << 14;  // of metallic, roughness, normal scale, ior, specular
const uint FEATURE_MIRROR = 1u << 15;       // mirrors the picture of its own mirrored view
const uint FEATURE_PROBE = 1u << 16;        // mirrors a captured cube, from where it stands
const uint FEATURE_TRACED_REFLECTION = 1u << 17;  // ray-traced reflection
const uint FEATURE_GLASS = 1u << 18;        // seen through, against a backdrop
const uint FEATURE_SOLID = 1u << 19;        // glass with an inside: two interfaces and a path between
const uint FEATURE_TRACED_GLASS = 1u << 20; // seen through, along rays
const uint FEATURE_PARALLAX = 1u << 21;     // the cube is read as the inside of a box
const uint FEATURE_TRANSMISSION_MAP = 1u << 22;  // transmission has a texture
const uint FEATURE_THICKNESS_MAP = 1u << 23;     // thickness has a texture
const uint FEATURE_BACKDROP = 1u << 24;     // what is behind it was drawn and copied
const uint FEATURE_MAP = 1u << 25;          // reflects the material's own stored map
const uint FEATURE_PARALLAX_DEPTH = 1u << 26;  // parallax correction by the depths of the cube
const uint FEATURE_MIRROR_SAMPLES = 1u << 27;  // a rough flat mirror adds up directions
const uint FEATURE_BACK_FACES = 1u << 28;   // the backs of solid glass were drawn
const uint FEATURE_MAP_SAMPLES = 1u << 29;  // several look-ups along a rough lobe at an angle
const uint FEATURE_PACKED_NORMAL = 1u << 30;  // the normal map holds metallic and roughness too

const uint FEATURE_WIDE_LOBE = 1u << 31;  // rough: mirrors harmonics, and only a coat's highlight is narrow

// What holds for every draw of a view: bits of VIEW.
const uint VIEW_ORTHOGRAPHIC = 1u << 0;
const uint VIEW_SUN_ONLY = 1u << 1;  // the only light is directional, the first in the table
const uint VIEW_LIGHTS_SHIFT = 2u;    // two bits: each lit draw has the first 1, 2 or 3 lights of the
const uint VIEW_LIGHTS_MASK = 3u;     // table, which have neither range nor cone; 0: it has a list
const uint VIEW_SHADOWS = 1u << 5;      // lights have shadows
const uint VIEW_SHADOWS_ONE = 1u << 6;  // of one picture each (LightShadow::Kind)
const uint VIEW_SHADOWS_SIX = 1u << 7;  // of six each
const uint VIEW_SHADOWS_SOFT = 1u << 8;  // a light has a radius
const uint VIEW_SHADOWS_TINTED = 1u << 9;  // by glass and blended surfaces
const uint VIEW_SHADOWS_NEAR = 1u << 14;  // a light has nearer pictures (LightShadow::nearer)
const uint VIEW_COVERAGE = 1u << 10;  // alpha is the share of a pixel that surfaces cover
const uint VIEW_SHARED_PROGRAMS = 1u << 11;  // some meshes have no colours; see drawNumbers
const uint VIEW_SURFACE_LIGHT = 1u << 4;  // vertices have light of their surroundings
const uint VIEW_EMITTERS = 1u << 12;  // and light of emissive surfaces, for specular lobes
const uint VIEW_ROUND_LIGHTS = 1u << 13;  // a light has a radius, so that highlights show its disc
#define viewHas(bit) ((VIEW & (bit)) != 0u)  // a macro as has() is

// Layers of a draw's material and their textures: bits of LAYERS, the upper half of Draw::features.
// HIT_LAYERS: those that some surface has which rays may meet.
const uint LAYER_CLEARCOAT = 1u << 0;
const uint LAYER_CLEARCOAT_MAP = 1u << 1;
const uint LAYER_CLEARCOAT_ROUGHNESS_MAP = 1u << 2;
const uint LAYER_CLEARCOAT_NORMAL_MAP = 1u << 3;
const uint LAYER_CLEARCOAT_MIRRORS = 1u << 4;  // the coat, not the base, mirrors the picture or rays
const uint LAYER_SHEEN = 1u << 5;
const uint LAYER_SHEEN_COLOR_MAP = 1u << 6;
const uint LAYER_SHEEN_ROUGHNESS_MAP = 1u << 7;
const uint LAYER_IRIDESCENCE = 1u << 8;
const uint LAYER_IRIDESCENCE_MAP = 1u << 9;
const uint LAYER_IRIDESCENCE_THICKNESS_MAP = 1u << 10;
const uint LAYER_ANISOTROPY = 1u << 11;
const uint LAYER_ANISOTROPY_MAP = 1u << 12;
const uint LAYER_DIFFUSE_TRANSMISSION = 1u << 13;
const uint LAYER_DIFFUSE_TRANSMISSION_MAP = 1u << 14;
const uint LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP = 1u << 15;
const uint LAYER_DISPERSION = 1u << 16;
const uint LAYER_SPECULAR_MAP = 1u << 17;
const uint LAYER_SPECULAR_COLOR_MAP = 1u << 18;
const uint LAYER_SHADOW_CATCHER = 1u << 19;  // a ground that shows what the scene changes on it
const uint LAYERS_WITH_TANGENTS = LAYER_CLEARCOAT_NORMAL_MAP | LAYER_ANISOTROPY;
#define layered(bit) ((LAYERS & (bit)) != 0u)  // a macro as has() is
