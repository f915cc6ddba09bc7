// What a draw's shader variant can do, one bit each; compiled as GLSL and as C++.
// The program is compiled with a constant FEATURES, so what is not asked for is not there.

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
