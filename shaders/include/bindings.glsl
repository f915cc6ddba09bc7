// Every number that C++ and the shaders have to agree on: blocks, texture units, attribute slots.

// Uniform blocks.
#define BINDING_VIEW 0
#define BINDING_MATERIAL 1
#define BINDING_PREFILTER 2
#define BINDING_FILTER 3
#define BINDING_REFLECTION 4
#define BINDING_TRACE 5
#define BINDING_LAYERS 6

// Texture units.
#define UNIT_BASE_COLOR 0
#define UNIT_METALLIC_ROUGHNESS 1
#define UNIT_NORMAL 2
#define UNIT_OCCLUSION 3
#define UNIT_EMISSIVE 4
#define UNIT_ENVIRONMENT 5
#define UNIT_ENVIRONMENT_BRDF 6
#define UNIT_LIGHTS 7
#define UNIT_SOURCE 8
#define UNIT_MIRROR 9
#define UNIT_BACKDROP 10
#define UNIT_TRANSMISSION 11
#define UNIT_THICKNESS 12
#define UNIT_BACK_FACES 30
#define UNIT_SPREAD 29
#define UNIT_LENS 28
#define UNIT_SAMPLED_PIXELS 27
#define UNIT_TRACE_NODES 13
#define UNIT_TRACE_TRIANGLES 14
#define UNIT_TRACE_VERTICES 15
#define UNIT_TRACE_INDICES 16
#define UNIT_TRACE_INSTANCES 17
#define UNIT_TRACE_MATERIALS 18
#define UNIT_TRACE_TEXELS 19
#define UNIT_SURFACE_LIGHT 20
#define UNIT_SHADOWS 21
#define UNIT_SHADOW_DEPTHS 22
#define UNIT_SHADOW_TINTS 23
// Of the slots from SLOT_SPECULAR on, one after another.
#define UNIT_SPECULAR 32
#define UNIT_SPECULAR_COLOR 33
#define UNIT_CLEARCOAT 34
#define UNIT_CLEARCOAT_ROUGHNESS 35
#define UNIT_CLEARCOAT_NORMAL 36
#define UNIT_SHEEN_COLOR 37
#define UNIT_SHEEN_ROUGHNESS 38
#define UNIT_IRIDESCENCE 39
#define UNIT_IRIDESCENCE_THICKNESS 40
#define UNIT_ANISOTROPY 41
#define UNIT_DIFFUSE_TRANSMISSION 42
#define UNIT_DIFFUSE_TRANSMISSION_COLOR 43

// The slots of a material's textures: the first five are their own units.
#define SLOT_TRANSMISSION 5
#define SLOT_THICKNESS 6
#define SLOT_SPECULAR 7
#define SLOT_SPECULAR_COLOR 8
#define SLOT_CLEARCOAT 9
#define SLOT_CLEARCOAT_ROUGHNESS 10
#define SLOT_CLEARCOAT_NORMAL 11
#define SLOT_SHEEN_COLOR 12
#define SLOT_SHEEN_ROUGHNESS 13
#define SLOT_IRIDESCENCE 14
#define SLOT_IRIDESCENCE_THICKNESS 15
#define SLOT_ANISOTROPY 16
#define SLOT_DIFFUSE_TRANSMISSION 17
#define SLOT_DIFFUSE_TRANSMISSION_COLOR 18
#define MATERIAL_SLOTS 19
#define BASE_SLOTS 7
#define LAYER_SLOTS 12  // from SLOT_SPECULAR on

// Vertex attributes; the last six belong to the draw.
#define ATTRIBUTE_POSITION 0
#define ATTRIBUTE_NORMAL 1
#define ATTRIBUTE_TANGENT 2
#define ATTRIBUTE_TEXCOORD0 3
#define ATTRIBUTE_TEXCOORD1 4
#define ATTRIBUTE_COLOR 5
#define ATTRIBUTE_EYE_FROM_MODEL 6
#define ATTRIBUTE_NORMAL_FROM_MODEL 9

// Rows of four integers for each value of light at a vertex (renderer/light/surface_light.h).
#define SURFACE_LIGHT_ROWS 2

// Texels of the light table: first the nine harmonics as 27 numbers one after another, then so many
// for each light: its position (or direction), its power, its cone, and where its shadows are: about
// them, their tile, four rows of the transform to it, its disc, and two for each nearer picture: from
// clip space of the whole one to 0..1 of this, and its corner and edge in texels and the extent of a
// texel in metres (draw_stream.cpp).
#define HARMONIC_ROWS 7
#define LIGHT_ROWS 16
#define NEAR_SHADOW_ROW 10  // the first, of a light
#define NEAR_SHADOWS 3

// Levels that colours are read from below the one whose texel is as wide as a pixel. Two bilinear
// look-ups of it average over two pixels and more; half as wide, they cover about the pixel.
#define COLOR_LEVELS_BELOW 1

// The edge filter: bits of its variant, and what it changes of a picture with several samples where it has
// contrast, relative to one with a single sample. 0.4 and 0.6 have the smallest mean errors in 13 scenes.
#define EDGES_COMPRESSED 1
#define EDGES_OF_SAMPLES 2
#define EDGE_SHARE_OF_SAMPLES 0.45f

// Texels for each node, triangle, vertex (of two floats), instance and material of the traced tier.
#define TRACE_NODE_ROWS 2
#define TRACE_TRIANGLE_ROWS 3
#define TRACE_VERTEX_PAIRS 9
#define TRACE_INSTANCE_ROWS 7
#define TRACE_MATERIAL_ROWS 50
#define TRACE_LAYERS 21  // a LayerBlock follows the MaterialBlock
#define TRACE_TEXTURE_ROWS 16  // a row about it, and one for each level

// What a traced material is, bit by bit; PANE and SOLID are of an instance.
#define TRACE_MASK 1
#define TRACE_BLEND 2
#define TRACE_DOUBLE_SIDED 4
#define TRACE_UNLIT 8
#define TRACE_PANE 16
#define TRACE_SOLID 32
#define TRACE_MIRROR_FLAT 64  // where it is flat, it mirrors the scene
#define TRACE_MIRROR_CURVED 128
#define TRACE_PACKED_NORMAL 256

// Directions that one prefilter pass can add up.
#define PREFILTER_SAMPLES 1024

// What a channel pass writes.
#define CHANNEL_DEPTH 1
#define CHANNEL_NORMAL 2
#define CHANNEL_NUMBER 3
#define CHANNEL_POSITION 4
#define CHANNEL_ALBEDO 5
#define CHANNEL_SURFACE 6
#define CHANNEL_BACK_FACES 8

// A flag of the variant of a full-screen pass that draws in chosen pixels only; see sampled_pixels.glsl.
#define SAMPLED_PIXELS 8

// What a lens pass assembles.
#define LENS_RADIANCE 0
#define LENS_NUMBERS 1

// Curves of the toneMap pass.
#define TONE_MAP_NEUTRAL 0
#define TONE_MAP_ACES 1
#define TONE_MAP_LINEAR 2
#define TONE_MAP_TRANSPARENT 4  // a flag that is added to the curve
